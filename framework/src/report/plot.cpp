#include "report/plot.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "report/packing.hpp"

namespace gripline::report {
namespace {

constexpr double margin_left = 58, margin_right = 14, margin_top = 30, margin_bottom = 44;
constexpr const char* ink = "#1a1c20";
constexpr const char* muted = "#62676f";
constexpr const char* grid = "#e7e5e0";

/// Shortest text of at most `digits` significant digits with a true minus, the same in every locale.
std::string text(double value, int digits = 5) {
  char buffer[40];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, std::abs(value), std::chars_format::general, digits).ptr;
  return (value < 0 ? "−" : "") + std::string(buffer, end);
}
std::string pixel(double value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, std::round(value * 100) / 100).ptr;
  return {buffer, end};
}

/// From data to pixels along one axis.
struct Scale {
  double low, high, from, to;
  bool logarithmic;
  [[nodiscard]] double operator()(double v) const {
    if (logarithmic) return from + std::log(v / low) / std::log(high / low) * (to - from);
    return from + (v - low) / (high - low) * (to - from);
  }
};

struct PlotFrame {
  double left, top, width, height;
};

bool usable(double v, bool logarithmic) { return std::abs(v) <= drawable_limit && (!logarithmic || v > 0); }

void widen(double& low, double& high, const std::vector<double>& values, bool logarithmic) {
  for (const double v : values) {
    if (!usable(v, logarithmic)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
}

/// The range of an axis: what is given, else what the series span with a little air.
std::pair<double, double> range_of(const Axis& axis, const std::vector<Series>& series, bool along_x) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& s : series) {
    widen(low, high, along_x ? s.x : s.y, axis.logarithmic);
    if (!along_x) widen(low, high, s.high, axis.logarithmic);
  }
  if (!(low <= high)) low = axis.logarithmic ? 0.1 : 0, high = 1;
  const bool never_negative = low >= 0;
  if (axis.logarithmic) {
    low /= 1.3;
    high *= 1.3;
  } else {
    const double air = high > low ? 0.05 * (high - low) : std::max(0.1 * std::abs(high), 0.1);
    low = never_negative ? std::max(0.0, low - air) : low - air;
    high += air;
  }
  low = axis.low.value_or(low);
  high = axis.high.value_or(high);
  return {low, high > low ? high : low + 1};
}

std::vector<std::pair<double, std::string>> ticks_of(const Axis& axis, double low, double high, int count) {
  if (!axis.ticks.empty()) return axis.ticks;
  std::vector<std::pair<double, std::string>> ticks;
  if (axis.logarithmic) {
    const bool fine = high / low < 200;
    for (double power = std::pow(10, std::floor(std::log10(low))); power > 0 && power <= high; power *= 10)
      for (const double digit : {1.0, 2.0, 5.0})
        if (digit * power >= low && digit * power <= high && (fine || digit == 1))
          ticks.emplace_back(digit * power, text(digit * power));
  } else {
    for (const double v : round_ticks(low, high, count)) ticks.emplace_back(v, text(v));
  }
  return ticks;
}

class Document {
 public:
  void write(double x, double y, const std::string& words, const char* colour, int size, const char* anchor,
             bool bold = false) {
    out_ += "<text x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" fill=\"" + colour + "\" font-size=\"" +
            std::to_string(size) + "\" text-anchor=\"" + anchor + "\"" + (bold ? " font-weight=\"600\"" : "") + ">" +
            html_escaped(words) + "</text>\n";
  }
  void path(const std::string& d, const Series& s, bool fill) {
    out_ += "<path d=\"" + d + "\" " + (fill ? "stroke=\"none\" fill=\"" : "fill=\"none\" stroke=\"") + s.colour + "\"";
    if (!fill) out_ += " stroke-width=\"" + pixel(s.width) + "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
    if (fill) out_ += " fill-rule=\"evenodd\"";
    if (!s.dash.empty()) out_ += " stroke-dasharray=\"" + s.dash + "\"";
    if (s.opacity < 1) out_ += " opacity=\"" + pixel(s.opacity) + "\"";
    out_ += "/>\n";
  }
  void raw(const std::string& markup) { out_ += markup; }
  [[nodiscard]] const std::string& text() const { return out_; }

 private:
  std::string out_;
};

/// "M x y L x y ..." with a new piece after every gap; steps go along x first.
std::string trace(const Series& s, const Scale& sx, const Scale& sy, bool points) {
  std::string d;
  bool down = false;
  double last_y = 0;
  for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
    if (!usable(s.x[i], sx.logarithmic) || !usable(s.y[i], sy.logarithmic)) {
      down = false;
      continue;
    }
    const double x = sx(s.x[i]), y = sy(s.y[i]);
    if (points) {
      d += "M" + pixel(x) + " " + pixel(y) + "h0";
      continue;
    }
    if (down && s.kind == Series::Kind::step) d += "L" + pixel(x) + " " + pixel(last_y);
    d += (down ? "L" : "M") + pixel(x) + " " + pixel(y);
    last_y = y;
    down = true;
  }
  return d;
}

std::string band(const Series& s, const Scale& sx, const Scale& sy) {
  std::string d, back;
  for (std::size_t i = 0; i < std::min({s.x.size(), s.y.size(), s.high.size()}); ++i) {
    if (!usable(s.y[i], sy.logarithmic) || !usable(s.high[i], sy.logarithmic)) continue;
    d += (d.empty() ? "M" : "L") + pixel(sx(s.x[i])) + " " + pixel(sy(s.y[i]));
    back.insert(0, "L" + pixel(sx(s.x[i])) + " " + pixel(sy(s.high[i])));
  }
  return d + back + (d.empty() ? "" : "Z");
}

void draw_series(Document& out, const Series& s, const Scale& sx, const Scale& sy) {
  using enum Series::Kind;
  if (s.kind == band) {
    if (const std::string d = report::band(s, sx, sy); !d.empty()) out.path(d, s, true);
    return;
  }
  const std::string d = trace(s, sx, sy, s.kind == points);
  if (!d.empty()) out.path(s.kind == closed ? d + "Z" : d, s, s.kind == closed && s.filled);
}

void draw_axes(Document& out, const Panel& panel, const PlotFrame& f, const Scale& sx, const Scale& sy) {
  const double bottom = f.top + f.height;
  for (const auto& [v, words] : ticks_of(panel.x, sx.low, sx.high, static_cast<int>(f.width / 70))) {
    out.raw("<path d=\"M" + pixel(sx(v)) + " " + pixel(f.top) + "V" + pixel(bottom) + "\" stroke=\"" + grid + "\"/>\n");
    out.write(sx(v), bottom + 15, words, muted, 11, "middle");
  }
  for (const auto& [v, words] : ticks_of(panel.y, sy.low, sy.high, static_cast<int>(f.height / 38))) {
    out.raw("<path d=\"M" + pixel(f.left) + " " + pixel(sy(v)) + "H" + pixel(f.left + f.width) + "\" stroke=\"" + grid +
            "\"/>\n");
    out.write(f.left - 7, sy(v) + 4, words, muted, 11, "end");
  }
  out.write(f.left + f.width / 2, bottom + 33, panel.x.label, muted, 11, "middle");
  out.write(f.left, f.top - 7, panel.y.label, muted, 11, "start");
}

/// Texts beside their points: inside the frame, over no other text.
void draw_labels(Document& out, const Panel& panel, const PlotFrame& f, const Scale& sx, const Scale& sy) {
  struct Box {
    double x, y, width;
  };
  std::vector<Box> taken;
  for (const auto& [at, words] : panel.labels) {
    const double width = 6.4 * static_cast<double>(words.size()), x = sx(at[0]), y = sy(at[1]);
    const Box beside[] = {{x + 9, y - 6, width},          {x + 9, y + 14, width}, {x - 9 - width, y - 6, width},
                          {x - 9 - width, y + 14, width}, {x + 9, y - 20, width}, {x - 9 - width, y - 20, width},
                          {x + 9, y - 34, width},         {x + 9, y - 48, width}};
    const auto fits = [&](const Box& b) {
      if (b.x < f.left || b.x + width > f.left + f.width || b.y < f.top || b.y > f.top + f.height) return false;
      return std::none_of(taken.begin(), taken.end(), [&](const Box& t) {
        return std::abs(t.y - b.y) < 12 && t.x < b.x + b.width && b.x < t.x + t.width;
      });
    };
    const Box* place = std::find_if(std::begin(beside), std::end(beside), fits);
    if (place == std::end(beside)) place = beside;
    taken.push_back(*place);
    out.write(place->x, place->y, words, ink, 11, "start");
  }
}

void draw_panel(Document& out, const Panel& panel, PlotFrame f, const std::string& clip) {
  auto [x0, x1] = range_of(panel.x, panel.series, true);
  auto [y0, y1] = range_of(panel.y, panel.series, false);
  if (panel.equal) {
    const double scale = std::max((x1 - x0) / f.width, (y1 - y0) / f.height);
    const double cx = (x0 + x1) / 2, cy = (y0 + y1) / 2;
    x0 = cx - scale * f.width / 2, x1 = cx + scale * f.width / 2;
    y0 = cy - scale * f.height / 2, y1 = cy + scale * f.height / 2;
  }
  const Scale sx{x0, x1, f.left, f.left + f.width, panel.x.logarithmic};
  const Scale sy{y0, y1, f.top + f.height, f.top, panel.y.logarithmic};
  if (panel.axes) draw_axes(out, panel, f, sx, sy);
  if (!panel.title.empty()) out.write(f.left + f.width, f.top - 7, panel.title, ink, 12, "end", true);
  out.raw("<clipPath id=\"" + clip + "\"><rect x=\"" + pixel(f.left) + "\" y=\"" + pixel(f.top - 6) + "\" width=\"" +
          pixel(f.width) + "\" height=\"" + pixel(f.height + 12) + "\"/></clipPath>\n<g clip-path=\"url(#" + clip +
          ")\">\n");
  for (const Series& s : panel.series) draw_series(out, s, sx, sy);
  out.raw("</g>\n");
  draw_labels(out, panel, f, sx, sy);
}

/// One entry per label over all panels; returns the height it took.
double draw_legend(Document& out, const std::vector<Panel>& panels, double width) {
  std::set<std::string> seen;
  double x = margin_left, y = 42;
  bool any = false;
  for (const Panel& panel : panels)
    for (const Series& s : panel.series) {
      if (s.label.empty() || !seen.insert(s.label).second) continue;
      const double length = 34 + 6.6 * static_cast<double>(s.label.size());
      if (x + length > width && x > margin_left) x = margin_left, y += 18;
      Series sample = s;
      sample.width = s.kind == Series::Kind::points ? 7 : std::max(s.width, 2.0);
      sample.opacity = 1;
      out.path(s.kind == Series::Kind::points ? "M" + pixel(x + 8) + " " + pixel(y - 4) + "h0"
                                              : "M" + pixel(x) + " " + pixel(y - 4) + "h17",
               sample, false);
      out.write(x + 23, y, s.label, ink, 11, "start");
      x += length + 12;
      any = true;
    }
  return any ? y - 24 : 0;
}

}  // namespace

std::string series_colour(std::size_t index) {
  constexpr std::array colours{"#0072b2", "#d55e00", "#009e73", "#b0529a", "#c28a00",
                               "#3aa0dc", "#6a6f78", "#5b45b0", "#8a5a2b", "#6f8f00"};
  return colours[index % colours.size()];
}

std::string sequential_colour(double share) {
  constexpr std::array<std::array<int, 3>, 10> viridis{{{68, 1, 84},
                                                        {72, 40, 120},
                                                        {62, 74, 137},
                                                        {49, 104, 142},
                                                        {38, 130, 142},
                                                        {31, 158, 137},
                                                        {53, 183, 121},
                                                        {110, 206, 88},
                                                        {181, 222, 43},
                                                        {253, 231, 37}}};
  const double place = std::clamp(share, 0.0, 1.0) * 0.93 * (viridis.size() - 1);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(place), viridis.size() - 2);
  std::string colour = "#";
  for (std::size_t k = 0; k < 3; ++k) {
    const int value = static_cast<int>(
        std::lround(viridis[i][k] + (place - static_cast<double>(i)) * (viridis[i + 1][k] - viridis[i][k])));
    colour += "0123456789abcdef"[value / 16];
    colour += "0123456789abcdef"[value % 16];
  }
  return colour;
}

std::vector<double> round_ticks(double low, double high, int count) {
  const double rough = (high - low) / std::max(count, 1);
  if (!(rough > 0) || !std::isfinite(rough)) return {low};
  const double power = std::pow(10, std::floor(std::log10(rough))), lead = rough / power;
  const double step = power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  // Counted, because adding a step below the rounding error of `low` would never reach `high`.
  for (int i = 0; i <= 3 * std::max(count, 1) && (first + i) * step <= high + 1e-9 * step; ++i)
    ticks.push_back((first + i) * step);
  return ticks;
}

std::string draw_panels(const std::string& title, const std::vector<Panel>& panels, int columns, double width,
                        double height) {
  const auto shown = std::max<std::size_t>(1, std::min(panels.size(), static_cast<std::size_t>(std::max(columns, 1))));
  const std::size_t rows = (panels.size() + shown - 1) / shown;
  const double total_width = width * static_cast<double>(shown);
  Document body;
  const double legend = draw_legend(body, panels, total_width - margin_right);
  const double head = 34 + legend;
  const double total_height = head + height * static_cast<double>(rows);
  body.write(margin_left, 20, title, ink, 14, "start", true);
  // Ids unique to this figure: several may be embedded in one page.
  std::string name = "clip-";
  std::copy_if(title.begin(), title.end(), std::back_inserter(name),
               [](unsigned char c) { return c < 0x80 && std::isalnum(c) != 0; });
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double left = width * static_cast<double>(i % shown), top = head + height * static_cast<double>(i / shown);
    draw_panel(
        body, panels[i],
        {left + margin_left, top + margin_top, width - margin_left - margin_right, height - margin_top - margin_bottom},
        name + std::to_string(i));
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + pixel(total_width) + "\" height=\"" +
         pixel(total_height) + "\" viewBox=\"0 0 " + pixel(total_width) + " " + pixel(total_height) +
         "\" font-family=\"Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif\">\n" +
         "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" + body.text() + "</svg>\n";
}

}  // namespace gripline::report
