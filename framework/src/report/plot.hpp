// Line, point and area charts as SVG files, in light colours for print.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace gripline::report {

/// Colours that readers with any colour vision can tell apart; the same as the page's light scheme.
std::string series_colour(std::size_t index);
/// Viridis at a share of 0..1.
std::string sequential_colour(double share);

struct Series {
  enum class Kind { line, step, points, band, closed };
  Kind kind = Kind::line;
  std::vector<double> x, y;  // points with a number missing interrupt a line
  std::vector<double> high;  // band: y is its lower edge
  std::string colour = "#1a1c20";
  std::string label;   // empty: not in the legend
  std::string dash;    // "6 4" and the like
  double width = 1.5;  // of lines; of points their diameter [px]
  double opacity = 1;
  bool filled = false;  // closed: as an area without an outline
};

struct Axis {
  std::string label;
  bool logarithmic = false;
  std::optional<double> low, high;                    // without them, what the series need
  std::vector<std::pair<double, std::string>> ticks;  // in place of round numbers
};

struct Panel {
  std::string title;
  Axis x, y;
  std::vector<Series> series;
  bool equal = false;  // one scale for both axes
  bool axes = true;
  std::vector<std::pair<std::array<double, 2>, std::string>> labels;  // texts beside points
};

/// Round numbers within [low, high], about `count` of them.
std::vector<double> round_ticks(double low, double high, int count);

/// Panels from left to right and top to bottom, one legend above them all. `width` and `height` of one panel [px].
std::string draw_panels(const std::string& title, const std::vector<Panel>& panels, int columns, double width,
                        double height);

}  // namespace gripline::report
