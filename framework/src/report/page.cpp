#include "report/page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "report/bundle.hpp"
#include "report/series.hpp"
#include "report/tables.hpp"

namespace gripline::report {
namespace {

constexpr double channels_per_step = 22;  // about what step_channels gives, for the budget
constexpr double bytes_single = 16.0 / 3, bytes_half = 8.0 / 3;

nlohmann::json packed_columns(const Columns& table, Precision precision, std::size_t stride = 1) {
  nlohmann::json out = nlohmann::json::object();
  for (const std::string& name : table.names())
    out[name] = pack(thin(table.numbers(name), Thinning::sample, stride), precision);
  return out;
}

/// Where the snapshots of one axle stand in tyres.csv: their rows follow one another.
std::vector<std::vector<std::size_t>> snapshots(const Columns& tyres, const char* axle) {
  std::vector<std::vector<std::size_t>> found;
  double last = std::nan("");
  for (std::size_t i = 0; i < tyres.rows(); ++i) {
    if (tyres.text("axle", i) != axle) continue;
    if (const double t = tyres.number("t_s", i); t != last) {
      last = t;
      found.emplace_back();
    }
    found.back().push_back(i);
  }
  return found;
}

/// Snapshots of one axle's curve one after the other, with where each begins.
nlohmann::json packed_tyres(const Columns& tyres, const char* axle, Precision precision, std::size_t stride) {
  std::map<std::string_view, std::vector<double>> kept;
  nlohmann::json times = nlohmann::json::array(), starts = nlohmann::json::array();
  const std::vector<std::vector<std::size_t>> all = snapshots(tyres, axle);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k % stride != 0 && k + 1 != all.size()) continue;
    times.push_back(number_or_null(tyres.number("t_s", all[k].front())));
    starts.push_back(kept["slip"].size());
    for (const std::size_t i : all[k]) {
      kept["slip"].push_back(tyres.number("slip_rad", i));
      kept["learned"].push_back(tyres.number("learned_n", i));
      kept["sigma"].push_back(tyres.number("sigma_n", i));
      kept["truth"].push_back(tyres.number("true_n", i));
    }
  }
  nlohmann::json out = {{"t", times}, {"start", starts}};
  for (const auto& [name, values] : kept) out[std::string(name)] = pack(values, precision);
  return out;
}

std::size_t count_undrawable(const std::vector<TimeSeries>& channels) {
  std::size_t count = 0;
  for (const TimeSeries& channel : channels)
    count += static_cast<std::size_t>(std::count_if(channel.values.begin(), channel.values.end(), [](double v) {
      return std::isinf(v) || std::abs(v) > drawable_limit;
    }));
  return count;
}

/// replay.csv with the belief's deviation of the whole car for those of its axles.
nlohmann::json replay_json(const Run& run, const CarShape& car, const Detail& detail) {
  nlohmann::json out = packed_columns(run.replay, detail.precision, detail.replay_stride);
  for (const char* axle : {"mu_sigma_front", "mu_sigma_rear"}) out.erase(axle);
  const std::vector<double> sigma = mu_sigma(run, car);
  if (!sigma.empty()) out["mu_sigma"] = pack(thin(sigma, Thinning::sample, detail.replay_stride), detail.precision);
  return out;
}

nlohmann::json run_json(const Run& run, const CarShape& car, const Detail& detail) {
  const std::vector<TimeSeries> channels = step_channels(run, car);
  nlohmann::json steps = nlohmann::json::object();
  for (const TimeSeries& channel : channels)
    steps[channel.name] = pack(thin(channel.values, channel.thinning, detail.stride), detail.precision);
  return {{"steps", std::move(steps)},
          {"stride", detail.stride},
          {"undrawable", count_undrawable(channels)},
          {"replay", replay_json(run, car, detail)},
          {"tyres",
           {{"front", packed_tyres(run.tyres, "front", detail.precision, detail.tyre_stride)},
            {"rear", packed_tyres(run.tyres, "rear", detail.precision, detail.tyre_stride)}}}};
}

using Histograms = std::map<std::pair<std::size_t, std::string>, TimeHistogram>;

void add_times(Histograms& histograms, const Columns& timing, std::size_t stack) {
  for (const std::string& column : timing.names())
    if (column.ends_with("_ms"))
      for (const double value : timing.numbers(column)) histograms[{stack, column}].add(value);
}

nlohmann::json times_json(const Histograms& histograms) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& [key, histogram] : histograms) {
    nlohmann::json entry = histogram.json();
    if (entry["n"] == 0) continue;
    entry["stack"] = key.first;
    entry["what"] = key.second;
    out.push_back(std::move(entry));
  }
  return out;
}

/// validation_traces.csv, grouped: [{"estimator", "channel", "t_s", "truth", "predicted", ...}].
nlohmann::json traces_json(const Columns& traces) {
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, std::vector<std::size_t>> rows;
  for (std::size_t i = 0; i < traces.rows(); ++i) {
    const std::pair key{traces.text("estimator", i), traces.text("channel", i)};
    if (!rows.contains(key)) order.push_back(key);
    rows[key].push_back(i);
  }
  nlohmann::json out = nlohmann::json::array();
  for (const auto& key : order) {
    nlohmann::json entry = {{"estimator", key.first}, {"channel", key.second}};
    for (const char* column : {"t_s", "truth", "predicted", "sigma", "slip_rad"}) {
      if (!traces.has(column)) continue;
      std::vector<double> values;
      for (const std::size_t row : rows[key]) values.push_back(traces.number(column, row));
      entry[column] = pack(values, Precision::single);
    }
    out.push_back(std::move(entry));
  }
  return out;
}

nlohmann::json validation_json(const Columns& validation) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t i = 0; i < validation.rows(); ++i)
    out.push_back({{"estimator", validation.text("estimator", i)},
                   {"channel", validation.text("channel", i)},
                   {"unit", validation.text("unit", i)},
                   {"n", number_or_null(validation.number("n", i))},
                   {"r2", number_or_null(validation.number("r2", i))},
                   {"rmse", number_or_null(validation.number("rmse", i))}});
  return out;
}

/// The cases of a diagnose experiment: [{"case", "verdict", "sentence", "page", "values": {...}}].
nlohmann::json cases_json(const Inputs& inputs) {
  nlohmann::json out = nlohmann::json::array();
  const Columns& table = inputs.diagnoses;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::string name = table.text("case", i);
    const std::filesystem::path folder = inputs.folder / name;
    std::error_code failed;
    nlohmann::json values = nlohmann::json::object();
    for (const std::string& column : table.names())
      if (std::isfinite(table.number(column, i))) values[column] = table.number(column, i);
    out.push_back({{"case", name},
                   {"verdict", table.text("verdict", i)},
                   {"sentence", sentence_of(folder)},
                   {"page", std::filesystem::exists(folder / "report.html", failed)},
                   {"values", std::move(values)}});
  }
  return out;
}

/// Lines of a text file, without counting its header.
double count_rows(const std::filesystem::path& file) {
  const std::string text = read_whole_file(file);
  return static_cast<double>(std::max<long>(0, std::count(text.begin(), text.end(), '\n') - 1));
}

Detail detail_of(const Inputs& inputs) {
  Cells cells;
  for (const RunName& run : inputs.runs) {
    const std::filesystem::path folder = inputs.folder / run.stack / run.seed;
    cells.steps += channels_per_step * count_rows(folder / "steps.csv");
    cells.replay += 48 * count_rows(folder / "replay.csv");
    cells.tyres += 4 * count_rows(folder / "tyres.csv");
  }
  return choose_detail(cells);
}

std::string script_data(const std::string& id, const nlohmann::json& value) {
  return "<script type=\"application/json\" id=\"" + id + "\">" + script_safe(value) + "</script>\n";
}

std::string title_of(const Inputs& inputs) {
  if (inputs.scene.is_object() && inputs.scene.contains("name") && inputs.scene["name"].is_string())
    return inputs.scene["name"].get<std::string>();
  const nlohmann::json& told = inputs.diagnosis_report;
  if (told.is_object() && told.contains("log") && told["log"].is_string()) return told["log"].get<std::string>();
  return std::filesystem::absolute(inputs.folder).lexically_normal().filename().string();
}

nlohmann::json stacks_json(const Inputs& inputs) {
  nlohmann::json out = nlohmann::json::array();
  for (const StackEntry& stack : inputs.stacks) out.push_back({{"name", stack.name}, {"truth", stack.needs_truth}});
  return out;
}

// The content security policy forbids every request: the page has only what stands in the file.
constexpr std::string_view head =
    R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
)"
    R"(<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; )"
    R"(script-src 'unsafe-inline'; img-src data: blob:">
<link rel="icon" href="data:,">
)";

}  // namespace

Detail choose_detail(const Cells& cells) {
  constexpr double tyre_share = 0.15;  // of a page that is full: curves change slowly
  if ((cells.steps + cells.replay + cells.tyres) * bytes_single <= exact_budget) return {};
  const auto stride = [](double bytes, double budget) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(bytes / budget)));
  };
  Detail detail{Precision::half, 1, 1, 1};
  double tyres = cells.tyres * bytes_half;
  const double others = (cells.steps + cells.replay) * bytes_half;
  if (tyres + others <= page_budget) return detail;
  detail.tyre_stride = stride(tyres, tyre_share * page_budget);
  tyres /= static_cast<double>(detail.tyre_stride);
  detail.stride = detail.replay_stride = stride(others, page_budget - tyres);
  return detail;
}

std::string page_html(const Inputs& inputs,
                      const std::function<void(std::size_t, std::size_t, const std::string&)>& progress) {
  const CarShape car = car_shape(inputs.scene);
  const Detail detail = detail_of(inputs);
  nlohmann::json runs = runs_json(inputs);
  std::string blocks;
  Histograms histograms;
  for (std::size_t i = 0; i < inputs.runs.size(); ++i) {
    const Run run = read_run(inputs, inputs.runs[i]);
    add_times(histograms, run.timing, runs[i]["stack"].get<std::size_t>());
    runs[i]["block"] = run.steps.empty() ? nlohmann::json(nullptr) : nlohmann::json("run-" + std::to_string(i));
    if (!run.steps.empty()) blocks += script_data("run-" + std::to_string(i), run_json(run, car, detail));
    if (progress) progress(i + 1, inputs.runs.size(), inputs.runs[i].stack + ", seed " + inputs.runs[i].seed);
  }
  const nlohmann::json meta = {{"version", GRIPLINE_VERSION},
                               {"title", title_of(inputs)},
                               {"scene", inputs.scene},
                               {"stacks", stacks_json(inputs)},
                               {"table", table_json(inputs)},
                               {"pairs", pairs_json(inputs)},
                               {"runs", std::move(runs)},
                               {"claims", claims_json(inputs.claims)},
                               {"times", times_json(histograms)},
                               {"track", packed_columns(inputs.track, Precision::single)},
                               {"line", packed_columns(inputs.line, Precision::single)},
                               {"validation", validation_json(inputs.validation)},
                               {"traces", traces_json(inputs.validation_traces)},
                               {"cases", cases_json(inputs)},
                               {"diagnosis", inputs.diagnosis},
                               {"diagnosis_report", inputs.diagnosis_report},
                               {"augmented_world", inputs.augmented_world},
                               {"provenance", inputs.provenance}};
  std::string html(head);
  html += "<title>" + html_escaped(title_of(inputs)) + " · gripline</title>\n<style>";
  html += bundled_style();
  html +=
      "</style>\n</head>\n<body>\n<div id=\"app\"><noscript>This report draws itself with JavaScript, which is off. "
      "Its numbers stand in runs.csv and table.csv beside it.</noscript></div>\n";
  html += script_data("meta", meta);
  html += blocks;
  html += "<script>";
  html += bundled_script();
  html += "</script>\n</body>\n</html>\n";
  return html;
}

}  // namespace gripline::report
