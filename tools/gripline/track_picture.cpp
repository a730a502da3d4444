#include "gripline/track_picture.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "util/numbers.hpp"

namespace gripline::tools {
namespace {

constexpr double width = 1000.0, border = 40.0;  // [px]

/// Metres of the road to pixels of the drawing.
class View {
 public:
  explicit View(const Track& track) {
    double top = -INFINITY, right = -INFINITY;
    for (int i = 0; i < 4000; ++i) {
      const CurvePoint at = track.at(track.length() * i / 4000);
      const double half = std::max(track.half_width_left(at.s), track.half_width_right(at.s));
      left_ = std::min(left_, at.x - half), right = std::max(right, at.x + half);
      bottom_ = std::min(bottom_, at.y - half), top = std::max(top, at.y + half);
    }
    scale_ = (width - 2 * border) / std::max(right - left_, top - bottom_);
    height_ = 2 * border + scale_ * (top - bottom_);
  }
  double height() const { return height_; }
  double scale() const { return scale_; }
  double x(double metres) const { return border + scale_ * (metres - left_); }
  double y(double metres) const { return height_ - border - scale_ * (metres - bottom_); }

 private:
  double left_ = INFINITY, bottom_ = INFINITY, scale_ = 1.0, height_ = 0.0;
};

PlanePoint beside(const Track& track, double s, double n) {
  const CurvePoint at = track.at(s);
  return {at.x - n * std::sin(at.yaw), at.y + n * std::cos(at.yaw)};
}

/// A closed path at this share of the half widths: +1 the left edge, -1 the right one.
std::string path(const Track& track, const View& view, double side) {
  const int count = static_cast<int>(std::clamp(track.length() * view.scale() / 3.0, 200.0, 6000.0));
  std::string out;
  for (int i = 0; i < count; ++i) {
    const double s = track.length() * i / count;
    const PlanePoint p = beside(track, s, side * (side > 0 ? track.half_width_left(s) : track.half_width_right(s)));
    out += format("%c%.1f %.1f", i == 0 ? 'M' : 'L', view.x(p.x), view.y(p.y));
  }
  return out + "Z";
}

void draw_start(const Track& track, const View& view, std::string& out) {
  const PlanePoint a = beside(track, 0, track.half_width_left(0)), b = beside(track, 0, -track.half_width_right(0));
  out += format("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"#c00\" stroke-width=\"3\"/>\n", view.x(a.x), view.y(a.y),
                view.x(b.x), view.y(b.y));
  const CurvePoint at = track.at(0);
  const double tip_x = view.x(at.x) + 24 * std::cos(at.yaw), tip_y = view.y(at.y) - 24 * std::sin(at.yaw);
  out += format("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"#c00\" stroke-width=\"2\"/>\n", view.x(at.x), view.y(at.y),
                tip_x, tip_y);
  out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"#c00\"/>\n", tip_x, tip_y);
}

/// A bar of 1, 2 or 5 times a power of ten metres, about a fifth of the drawing.
void draw_scale(const View& view, std::string& out) {
  const double wanted = 0.2 * width / view.scale(), ten = std::pow(10.0, std::floor(std::log10(wanted)));
  const double metres = wanted >= 5 * ten ? 5 * ten : wanted >= 2 * ten ? 2 * ten : ten;
  out += format("<path d=\"M%.1f %.1fh%.1f\" stroke=\"#000\" stroke-width=\"2\"/>\n", border, view.height() - 12,
                metres * view.scale());
  out += format("<text x=\"%.1f\" y=\"%.1f\" font-family=\"sans-serif\" font-size=\"13\">%g m</text>\n",
                border + metres * view.scale() + 6, view.height() - 8, metres);
}

}  // namespace

std::string picture_of(const Track& track) {
  const View view(track);
  std::string out;
  out += format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n", width, view.height());
  out.append("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n");
  for (const double side : {1.0, -1.0})
    out.append("<path fill=\"none\" stroke=\"#222\" stroke-width=\"1.5\" d=\"")
        .append(path(track, view, side))
        .append("\"/>\n");
  out.append("<path fill=\"none\" stroke=\"#888\" stroke-dasharray=\"6 6\" d=\"")
      .append(path(track, view, 0.0))
      .append("\"/>\n");
  draw_start(track, view, out);
  for (const Crossing& c : track.crossings())
    out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"none\" stroke=\"#06c\" stroke-width=\"2\"/>\n",
                  view.x(c.x), view.y(c.y));
  draw_scale(view, out);
  return out + "</svg>\n";
}

}  // namespace gripline::tools
