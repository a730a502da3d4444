#include "report/sweep_page.hpp"

#include <algorithm>
#include <cmath>

#include "report/html.hpp"
#include "report/packing.hpp"
#include "report/plot.hpp"
#include "util/numbers.hpp"

namespace gripline::report {
namespace {

using nlohmann::json;

constexpr std::size_t most_responses = 12;

/// The last name of a pointer is enough beside an axis.
std::string short_name(const std::string& factor) {
  const std::size_t slash = factor.rfind('/');
  return slash == std::string::npos || slash + 1 == factor.size() ? factor : factor.substr(slash + 1);
}

std::string short_level(std::string level) {
  constexpr std::size_t most = 18;
  if (level.size() > most) level = level.substr(0, most - 1) + "…";
  return level;
}

/// One response over the levels of one factor: medians with their intervals.
Panel level_panel(const std::string& response, const json& effect, double low, double high) {
  Panel panel;
  panel.title = short_name(text_of(effect, "factor"));
  panel.x.label = text_of(effect, "factor");
  panel.y.label = response;
  if (low < high) {
    panel.y.low = low - 0.05 * (high - low);
    panel.y.high = high + 0.05 * (high - low);
  }
  Series medians;
  medians.colour = series_colour(0);
  Series points = medians;
  points.kind = Series::Kind::points;
  points.width = 6;
  double at = 0;
  for (const json& level : list_of(effect, "levels")) {
    const double median = number_in(level, "median"), lo = number_in(level, "lo"), hi = number_in(level, "hi");
    panel.x.ticks.emplace_back(at, short_level(text_of(level, "level")));
    medians.x.push_back(at);
    medians.y.push_back(median);
    if (std::isfinite(lo) && std::isfinite(hi)) {
      Series bar;
      bar.x = {at, at};
      bar.y = {lo, hi};
      bar.colour = series_colour(0);
      bar.width = 4;
      bar.opacity = 0.4;
      panel.series.push_back(std::move(bar));
    }
    at += 1;
  }
  panel.x.low = -0.5;
  panel.x.high = at - 0.5;
  points.x = medians.x;
  points.y = medians.y;
  panel.series.push_back(std::move(medians));
  panel.series.push_back(std::move(points));
  return panel;
}

/// All levels of a response on one scale, so that panels can be compared.
std::pair<double, double> scale_of(const json& response) {
  double low = INFINITY, high = -INFINITY;
  for (const json& effect : list_of(response, "effects"))
    for (const json& level : list_of(effect, "levels"))
      for (const char* key : {"median", "lo", "hi"})
        if (const double value = number_in(level, key); std::isfinite(value)) {
          low = std::min(low, value);
          high = std::max(high, value);
        }
  return {low, high};
}

std::string multiples_figure(const json& response) {
  const auto [low, high] = scale_of(response);
  std::vector<Panel> panels;
  for (const json& effect : list_of(response, "effects"))
    panels.push_back(level_panel(text_of(response, "name"), effect, low, high));
  if (panels.empty()) return "";
  const int columns = static_cast<int>(std::min<std::size_t>(panels.size(), 3));
  return draw_panels(text_of(response, "name"), panels, columns, columns == 1 ? 600 : 320, 220);
}

/// Runs as lines over factors and responses, coloured by the first response.
std::string parallel_figure(const json& data) {
  const json& lines = list_of(data, "lines");
  const json &factors = list_of(data, "factors"), &responses = list_of(data, "responses");
  if (lines.empty() || factors.empty() || responses.empty()) return "";
  const std::size_t axes = lines.front().size();
  std::vector<double> low(axes, INFINITY), high(axes, -INFINITY);
  for (const json& line : lines)
    for (std::size_t i = 0; i < axes && i < line.size(); ++i)
      if (line[i].is_number()) {
        low[i] = std::min(low[i], line[i].get<double>());
        high[i] = std::max(high[i], line[i].get<double>());
      }
  const auto share = [&](const json& value, std::size_t axis) {
    if (!value.is_number()) return not_a_number;
    return high[axis] > low[axis] ? (value.get<double>() - low[axis]) / (high[axis] - low[axis]) : 0.5;
  };
  Panel panel;
  panel.y.ticks = {{0, "least"}, {1, "most"}};
  panel.y.low = -0.08;
  panel.y.high = 1.08;
  for (std::size_t i = 0; i < axes; ++i) {
    const bool factor = i < factors.size();
    const json& name = factor ? factors[i] : responses[i - factors.size()];
    panel.x.ticks.emplace_back(static_cast<double>(i),
                               factor ? short_name(name.get<std::string>()) : short_level(text_of(name, "name")));
  }
  panel.x.low = -0.3;
  panel.x.high = static_cast<double>(axes) - 0.7;
  for (const json& line : lines) {
    Series one;
    for (std::size_t i = 0; i < axes && i < line.size(); ++i) {
      one.x.push_back(static_cast<double>(i));
      one.y.push_back(share(line[i], i));
    }
    const double colour = factors.size() < line.size() ? share(line[factors.size()], factors.size()) : 0.5;
    one.colour = sequential_colour(std::isfinite(colour) ? colour : 0.5);
    one.width = 1;
    one.opacity = 0.4;
    panel.series.push_back(std::move(one));
  }
  return draw_panels("Runs over factors and responses, coloured by " + text_of(responses.front(), "name"), {panel}, 1,
                     940, 380);
}

std::string percent(double share) { return std::isfinite(share) ? short_number(std::round(100 * share)) + " %" : "–"; }

std::string sensitivity_table(const json& data) {
  std::vector<std::string> head{"response"};
  for (const json& factor : list_of(data, "factors")) head.push_back(factor.get<std::string>());
  head.emplace_back("seeds");
  std::vector<std::vector<std::string>> rows;
  for (const json& response : list_of(data, "responses")) {
    std::vector<std::string> row{text_of(response, "name")};
    for (const json& factor : list_of(data, "factors"))
      for (const json& effect : list_of(response, "effects"))
        if (text_of(effect, "factor") == factor.get<std::string>()) {
          const double total = number_in(effect, "total");
          row.push_back(percent(number_in(effect, "main")) + (std::isfinite(total) ? " (" + percent(total) + ")" : ""));
        }
    row.push_back(percent(number_in(response, "seeds_share")));
    rows.push_back(std::move(row));
  }
  return html_table(head, rows);
}

std::string best_table(const json& data, const json& response) {
  std::vector<std::string> head;
  for (const json& factor : list_of(data, "factors")) head.push_back(short_name(factor.get<std::string>()));
  for (const char* name : {"median", "95 %, or range", "runs", "as good as the first"}) head.emplace_back(name);
  std::vector<std::vector<std::string>> rows;
  for (const json& setting : list_of(response, "best")) {
    std::vector<std::string> row;
    for (const json& level : list_of(setting, "levels")) row.push_back(level.get<std::string>());
    row.push_back(short_number(number_in(setting, "median")));
    const double lo = number_in(setting, "lo"), hi = number_in(setting, "hi");
    row.push_back(std::isfinite(lo) && std::isfinite(hi) ? short_number(lo) + " to " + short_number(hi) : "–");
    row.push_back(short_number(number_in(setting, "runs")));
    row.push_back(rows.empty() ? "" : "p = " + short_number(number_in(setting, "p")));
    rows.push_back(std::move(row));
  }
  return html_table(head, rows);
}

/// The factor that explains most of a response's variance, or nothing.
const json* strongest(const json& response) {
  const json* found = nullptr;
  for (const json& effect : list_of(response, "effects"))
    if (std::isfinite(number_in(effect, "main")) &&
        (found == nullptr || number_in(effect, "main") > number_in(*found, "main")))
      found = &effect;
  return found;
}

/// One response in words: what it depends on, and at which setting it is best.
std::string sentence_of(const json& data, const json& response) {
  const json* const effect = strongest(response);
  if (effect == nullptr) return "";
  const std::string name = text_of(response, "name");
  const double share = number_in(*effect, "main"), seeds = number_in(response, "seeds_share");
  std::string text = name;
  if (std::isfinite(seeds) && seeds > share) {
    text += " differs more between seeds (" + percent(seeds) + " of the variance) than by any setting";
  } else {
    text += " depends most on " + short_name(text_of(*effect, "factor")) + ": " + percent(share);
    text += " of the variance";
    if (std::isfinite(seeds)) text += ", seeds " + percent(seeds);
  }
  const json& best = list_of(response, "best");
  if (best.empty()) return text + ".";
  text += response.value("higher_is_better", json()) == true ? "; largest, " : "; smallest, ";
  text += short_number(number_in(best.front(), "median")) + ", with ";
  const json &levels = list_of(best.front(), "levels"), &factors = list_of(data, "factors");
  for (std::size_t i = 0; i < levels.size() && i < factors.size(); ++i) {
    if (i > 0) text += ", ";
    text += short_name(factors[i].get<std::string>()) + " " + levels[i].get<std::string>();
  }
  return text + ".";
}

/// The page's first lines: what the sweep found, for the first responses.
std::string findings(const json& data) {
  constexpr std::size_t most = 4;
  std::string out;
  std::size_t count = 0;
  for (const json& response : list_of(data, "responses")) {
    const std::string text = sentence_of(data, response);
    if (text.empty() || count == most) continue;
    out += count++ == 0 ? "<p class=\"lead\">" + html_escaped(text) + "</p>\n" : "<p>" + html_escaped(text) + "</p>\n";
  }
  return out;
}

}  // namespace

std::vector<FigureFile> sweep_figures(const json& data) {
  std::vector<FigureFile> figures;
  if (std::string svg = parallel_figure(data); !svg.empty()) figures.push_back({"parallel.svg", std::move(svg)});
  std::size_t count = 0;
  for (const json& response : list_of(data, "responses")) {
    if (count++ == most_responses) break;
    if (std::string svg = multiples_figure(response); !svg.empty())
      figures.push_back({"multiples_" + text_of(response, "name") + ".svg", std::move(svg)});
  }
  return figures;
}

std::string sweep_page(const json& data) {
  std::string page = html_begin(text_of(data, "name"));
  page += findings(data);
  page += "<p>" + short_number(number_in(data, "finished")) + " of " + short_number(number_in(data, "runs")) +
          " runs finished";
  if (number_in(data, "broken") > 0) page += ", " + short_number(number_in(data, "broken")) + " broke";
  if (number_in(data, "missing") > 0)
    page += ", <strong>" + short_number(number_in(data, "missing")) + " are missing</strong>";
  page += ". Every run: table.csv.</p>\n";
  if (!list_of(data, "factors").empty() && !list_of(data, "responses").empty())
    page +=
        "<h2>What makes the difference</h2>\n<p>Share of the variance between runs that a factor explains alone, and "
        "in "
        "brackets with all its interactions; seeds: what is left between runs of one setting.</p>\n" +
        sensitivity_table(data);
  for (const FigureFile& figure : sweep_figures(data)) {
    if (figure.name == "parallel.svg") page += "<h2>All runs</h2>\n";
    page += "<figure>" + figure.svg + "</figure>\n";
    if (figure.name == "parallel.svg")
      page +=
          "<h2>Medians by level</h2>\n<p>With 95 % intervals (of fewer than six runs the range), one scale per "
          "response.</p>\n";
  }
  std::size_t count = 0;
  for (const json& response : list_of(data, "responses")) {
    if (count++ == most_responses || list_of(response, "best").empty()) continue;
    const bool higher = response.value("higher_is_better", json()) == true;
    const std::string title =
        "Best settings by " + text_of(response, "name") + (higher ? ", largest first" : ", smallest first");
    page += count == 1 ? "<h2>" + html_escaped(title) + "</h2>\n" + best_table(data, response)
                       : html_folded(title, best_table(data, response));
  }
  if (list_of(data, "responses").size() > most_responses)
    page += "<p>The other responses are in factors.csv, sensitivity.csv and best.csv.</p>\n";
  return page + "</body></html>\n";
}

}  // namespace gripline::report
