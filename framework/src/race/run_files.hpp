// The names of all files in the folder of a run. Whoever writes one takes its name from here, so that --force, which
// removes what a run left, finds them all.
#pragma once

#include <array>

namespace gripline::run_files {

inline constexpr const char* config = "config.json";
inline constexpr const char* draw = "draw.json";
inline constexpr const char* summary = "summary.json";
inline constexpr const char* steps = "steps.csv";
inline constexpr const char* timing = "timing.csv";
inline constexpr const char* timing_hash = "timing.sha256";
inline constexpr const char* replay = "replay.csv";
inline constexpr const char* tyres = "tyres.csv";
inline constexpr const char* line = "line.csv";
inline constexpr const char* log = "log.txt";

inline constexpr std::array all = {config, draw, summary, steps, timing, timing_hash, replay, tyres, line, log};

}  // namespace gripline::run_files
