#include "experiment/column_docs.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "experiment/race_columns.hpp"

namespace gripline {
namespace {

// Of runs.csv and table.csv, before the columns that are measured.
constexpr ColumnDoc identity[] = {
    {"runs.csv table.csv pairs.csv", "stack", "", "", "row of the experiment"},
    {"runs.csv", "seed", "", "", "of the run"},
    {"runs.csv", "status", "", "", "how the run ended: finished, crashed, stuck, timeout, plugin_error, error"},
    {"runs.csv table.csv", "needs_truth", "1", "",
     "1: is given the ground truth, and is marked * wherever it is shown"},
};

// Behind the columns that are measured (race_columns.hpp).
constexpr ColumnDoc others[] = {
    {"table.csv", "COLUMN_lo", "as COLUMN", "",
     "lower end of the 95 % bootstrap interval of the median of COLUMN; of fewer than six runs the smallest"},
    {"table.csv", "COLUMN_hi", "as COLUMN", "", "its upper end, or the largest"},
    {"pairs.csv", "baseline", "", "", "row that is subtracted"},
    {"pairs.csv", "column", "", "", "what is compared, a column of table.csv"},
    {"pairs.csv", "difference", "as column", "", "median over the seeds of stack minus baseline under the same seed"},
    {"pairs.csv", "lo", "as column", "",
     "lower end of its 95 % bootstrap interval; of fewer than six draws the smallest difference"},
    {"pairs.csv", "hi", "as column", "", "its upper end, or the largest"},
    {"pairs.csv", "p", "1", "", "two-sided sign test of \"plus is as likely as minus\""},
    {"pairs.csv", "draws", "1", "", "seeds under which both rows have the value"},
    {"steps.csv timing.csv replay.csv tyres.csv", "t_s", "s", "", "time since the start"},
    {"steps.csv", "x_m", "m", "", "position as sensed"},
    {"steps.csv", "y_m", "m", "", "position as sensed"},
    {"steps.csv", "yaw_rad", "rad", "", "heading as sensed, counter-clockwise from x, unwrapped"},
    {"steps.csv", "vx_mps", "m/s", "", "velocity forward as sensed"},
    {"steps.csv", "vy_mps", "m/s", "", "velocity to the left as sensed"},
    {"steps.csv", "yaw_rate_radps", "rad/s", "", "as sensed, positive to the left"},
    {"steps.csv", "d", "1", "",
     "throttle (positive) or brake (negative): given now where it is held over a step (zoh), else reached now"},
    {"steps.csv", "delta_rad", "rad", "", "road wheel angle commanded, as d"},
    {"steps.csv", "x_true_m", "m", "", "true position"},
    {"steps.csv", "y_true_m", "m", "", "true position"},
    {"steps.csv", "yaw_true_rad", "rad", "", "true heading"},
    {"steps.csv", "vx_true_mps", "m/s", "", "true velocity forward"},
    {"steps.csv", "vy_true_mps", "m/s", "", "true velocity to the left"},
    {"steps.csv", "yaw_rate_true_radps", "rad/s", "", "true yaw rate"},
    {"steps.csv", "d_applied", "1", "",
     "throttle that acts behind the plant's actuators; of a plant that is a plugin the one commanded"},
    {"steps.csv", "delta_applied_rad", "rad", "",
     "road wheel angle that acts behind the plant's actuators; of a plant that is a plugin the one commanded"},
    {"steps.csv", "mu_belief_front", "1", "", "estimated peak lateral force of the front axle over its static load"},
    {"steps.csv", "mu_belief_rear", "1", "", "the same of the rear axle"},
    {"steps.csv", "mu_true", "1", "", "true friction of the car"},
    {"steps.csv", "s_m", "m", "", "station on the centre line"},
    {"steps.csv", "offset_m", "m", "", "from the centre line to its left"},
    {"steps.csv", "lap", "1", "", "laps ended so far"},
    {"steps.csv", "outside", "1", "", "1: the centre of gravity is beyond an edge"},
    {"steps.csv", "v_ref_mps", "m/s", "", "speed of the first reference point"},
    {"steps.csv", "iterations", "1", "", "of the controller's solver"},
    {"steps.csv", "solved", "1", "", "0: the solve failed and a fallback was applied"},
    {"timing.csv", "update_ms", "ms", "", "CPU time of the estimator's call"},
    {"timing.csv", "plan_ms", "ms", "", "CPU time of the planner's call"},
    {"timing.csv", "solve_ms", "ms", "", "CPU time of the controller's call"},
    {"timing.csv", "cpu_s", "s", "", "CPU time of the process so far, its set-up included"},
    {"replay.csv", "mu_sigma_front", "1", "", "standard deviation of mu_belief_front"},
    {"replay.csv", "mu_sigma_rear", "1", "", "standard deviation of mu_belief_rear"},
    {"replay.csv", "slip_front_rad", "rad", "", "true slip angle of the front axle, under delta_applied_rad"},
    {"replay.csv", "slip_rear_rad", "rad", "", "true slip angle of the rear axle"},
    {"replay.csv", "force_front_n", "N", "",
     "true lateral force of the front axle at t_s, in the wheels' axes, positive to the left; of a plant that is a "
     "plugin, under the command before"},
    {"replay.csv", "force_rear_n", "N", "", "likewise of the rear axle"},
    {"replay.csv", "planK_x_m", "m", "", "the controller's prediction, ten points spread over its horizon"},
    {"replay.csv", "planK_y_m", "m", "", "the same"},
    {"replay.csv", "refK_x_m", "m", "", "the planner's reference, ten points spread over the horizon"},
    {"replay.csv", "refK_y_m", "m", "", "the same"},
    {"tyres.csv", "axle", "", "", "front or rear"},
    {"tyres.csv", "slip_rad", "rad", "", "slip angle of this point of the curve"},
    {"tyres.csv", "learned_n", "N", "", "lateral force as learned, at static load"},
    {"tyres.csv", "sigma_n", "N", "", "its standard deviation; empty where the estimator states none"},
    {"tyres.csv", "true_n", "N", "", "true lateral force, at static load and the present friction"},
    {"line.csv", "s_m", "m", "", "way along the line that the planner follows first"},
    {"line.csv", "x_m", "m", "", "position"},
    {"line.csv", "y_m", "m", "", "position"},
    {"track.csv", "s_m", "m", "", "station on the centre line"},
    {"track.csv", "x_m", "m", "", "centre line"},
    {"track.csv", "y_m", "m", "", "centre line"},
    {"track.csv", "left_x_m", "m", "", "left edge"},
    {"track.csv", "left_y_m", "m", "", "left edge"},
    {"track.csv", "right_x_m", "m", "", "right edge"},
    {"track.csv", "right_y_m", "m", "", "right edge"},
};

const char* sum_name(RowSum sum) {
  if (sum == RowSum::median) return "median";
  return sum == RowSum::largest ? "largest" : "sum";
}

struct FileDoc {
  const char* name;
  const char* meaning;
};
constexpr FileDoc files[] = {
    {"runs.csv", "one row per stack and seed"},
    {"table.csv", "one row per stack, over its runs that differ"},
    {"pairs.csv", "with `--baseline ROW`: one row per other stack and column"},
    {"steps.csv", "of a run, one row per control step; the first nine columns are a [measured log](logs.md)"},
    {"timing.csv", "of a run, one row per control step"},
    {"replay.csv", "of a run, one row per fifth control step, for the report"},
    {"tyres.csv", "of a run, tyre curves once a second"},
    {"line.csv", "of a run, closed: the first point is not repeated"},
    {"track.csv", "the road, closed"},
};

bool stands_in(const ColumnDoc& column, const std::string& file) {
  std::istringstream names(column.files);
  for (std::string name; names >> name;)
    if (name == file) return true;
  return false;
}

}  // namespace

std::span<const ColumnDoc> column_docs() {
  static const std::vector<ColumnDoc> all = [] {
    std::vector<ColumnDoc> docs(std::begin(identity), std::end(identity));
    for (const RaceColumn& column : race_columns())
      if (*column.files != '\0')
        docs.push_back({column.files, column.name, column.unit, sum_name(column.sum), column.meaning});
    docs.insert(docs.end(), std::begin(others), std::end(others));
    return docs;
  }();
  return all;
}

std::vector<std::string> documented_files() {
  std::vector<std::string> names;
  for (const FileDoc& file : files) names.emplace_back(file.name);
  return names;
}

std::vector<const ColumnDoc*> columns_of(const std::string& file) {
  std::vector<const ColumnDoc*> found;
  for (const ColumnDoc& column : column_docs())
    if (stands_in(column, file)) found.push_back(&column);
  return found;
}

std::string documented_name(const std::string& column) {
  if (column.size() > 3 && (column.ends_with("_lo") || column.ends_with("_hi")))
    return "COLUMN" + column.substr(column.size() - 3);
  for (const std::string_view counted : {"lap", "pace_ratio", "body_pace_ratio", "plan", "ref"}) {
    if (!column.starts_with(counted)) continue;
    const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(counted.size());
    const auto end = std::find_if_not(begin, column.end(), is_digit);
    if (end == begin) continue;
    return std::string(counted) + "K" + std::string(end, column.end());
  }
  return column;
}

std::string columns_page() {
  std::string page =
      "# Columns\n\nEvery column of the tables of a race, as `gripline columns` prints them; where the files stand: "
      "[output.md](output.md), how\nthe quantities are defined: [metrics.md](metrics.md). An empty cell is a value "
      "that "
      "was not measured. K counts from 0.\n\nMade by `gripline columns --markdown`.\n";
  for (const FileDoc& file : files) {
    const bool table = std::string_view(file.name) == "table.csv";
    page.append("\n## ").append(file.name).append("\n\n").append(file.meaning).append(".\n\n");
    page.append(table ? "| column | unit | over the runs | meaning |\n|---|---|---|---|\n"
                      : "| column | unit | meaning |\n|---|---|---|\n");
    for (const ColumnDoc* column : columns_of(file.name)) {
      page.append("| `").append(column->name).append("` | ").append(column->unit).append(" | ");
      if (table) page.append(column->of_rows).append(" | ");
      page.append(column->meaning).append(" |\n");
    }
  }
  return page;
}

}  // namespace gripline
