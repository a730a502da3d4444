// The page's program and style, built from tools/report and compiled in (see framework/cmake/EmbedReport.cmake).
#pragma once

#include <string_view>

namespace gripline::report {

std::string_view bundled_script();
std::string_view bundled_style();

}  // namespace gripline::report
