// What the program says when a plugin's code ends it: runs are processes of their own, but predict, diagnose and bench
// call plugins here.
#pragma once

namespace gripline::tools {

/// From now on until all_said(), a fatal signal and a call of exit() are told on stderr with the plugin called last;
/// a quiet exit(0) becomes the exit code of a run that broke. Standard streams that are closed are taken, so that
/// nobody's words end up in a file of results.
void prepare_last_words();
/// The program ends by itself.
void all_said();

}  // namespace gripline::tools
