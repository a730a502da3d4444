// What is said where a plugin's code ends the program: runs are processes of their own, but predict, diagnose and bench
// call plugins in this one.
#pragma once

namespace gripline::tools {

/// From now on until expect_end(), a fatal signal and a call of exit() are reported on stderr with the plugin called
/// last; exit(0) becomes the exit code of a failed run. Standard streams that are closed are opened (/dev/null), so
/// that no output goes into a file of results that gets their number.
void report_premature_end();
/// To be called when the program is about to end normally: a call of exit() is not reported from then on.
void expect_end();

}  // namespace gripline::tools
