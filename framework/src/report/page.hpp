// The page: its data as JSON in script elements that are not executed, and the bundle that draws them.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/inputs.hpp"
#include "report/packing.hpp"

namespace gripline::report {

/// How much is kept of each run, chosen so that the page stays below `page_budget` bytes.
struct Detail {
  Precision precision = Precision::single;
  std::size_t stride = 1;         ///< of steps.csv
  std::size_t replay_stride = 1;  ///< of replay.csv
  std::size_t tyre_stride = 1;    ///< of the snapshots of tyres.csv, the last one kept besides
};

inline constexpr double exact_budget = 4.5e6;  ///< bytes up to which every row is kept as float
inline constexpr double page_budget = 11.5e6;  ///< bytes of packed columns at most

/// Given how many numbers the files of all runs hold.
struct Cells {
  double steps = 0, replay = 0, tyres = 0;
};
Detail choose_detail(const Cells& cells);

/// The whole page as HTML. `progress(done, total, what)` is called per run.
std::string page_html(const Inputs& inputs,
                      const std::function<void(std::size_t, std::size_t, const std::string&)>& progress);

}  // namespace gripline::report
