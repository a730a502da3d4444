# Turns the report's committed bundle into one source file of raw strings: cmake -DSCRIPT= -DSTYLE= -DOUTPUT= -P EmbedReport.cmake
file(READ ${SCRIPT} script)
file(READ ${STYLE} style)
file(WRITE ${OUTPUT} "// Generated from tools/report/dist.
#include \"report/bundle.hpp\"

namespace gripline::report {

std::string_view bundled_script() { return R\"gripline~(${script})gripline~\"; }
std::string_view bundled_style() { return R\"gripline~(${style})gripline~\"; }

}  // namespace gripline::report
")
