// The line of least curvature at a constant speed: change it to your reference.
#include <cmath>
#include <numbers>
#include <vector>

#include <gripline/plugin.hpp>

namespace {

class NewPlugin final : public gripline::SpeedPlanner {
 public:
  struct Params {
    double speed = 0.8;  // the initializer is the default
  };
  static constexpr auto parameters() {  // JSON key, member, unit, range, one sentence
    return std::tuple{gripline::param("speed", &Params::speed, "m/s", {0.01, 100}, "speed along the line")};
  }
  NewPlugin(const gripline::PluginContext& context, const Params& params)
      : speed_(params.speed), dt_(context.dt), course_(*context.course), line_(600) {
    course_.minimum_curvature({.margin = 0.2 * context.car.width, .max_curvature = 0}, line_);
  }

  // horizon[k] is for the time now.t + k dt. belief.trusted says whether plans may rest on the belief.
  void plan(const gripline::Observation& now, const gripline::Belief& /*belief*/,
            const gripline::TyreCurve* /*learned: null until plans may rest on it*/,
            std::span<gripline::RefPoint> horizon) override {
    constexpr double pi = std::numbers::pi;
    const double side = now.at.direction, length = line_.back().s + line_[1].s;  // closed: the last gap is as the first
    std::size_t nearest = 0;
    const auto distance = [&](const gripline::LinePoint& p) { return std::hypot(p.x - now.x.x, p.y - now.x.y); };
    for (std::size_t i = 1; i < line_.size(); ++i)
      if (distance(line_[i]) < distance(line_[nearest])) nearest = i;
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      const double ahead = static_cast<double>(k) * speed_ * dt_, s = line_[nearest].s + side * ahead;
      const double place = (s / length - std::floor(s / length)) * static_cast<double>(line_.size());
      const std::size_t i = static_cast<std::size_t>(place) % line_.size();
      const gripline::LinePoint &p = line_[i], &q = line_[(i + 1) % line_.size()];
      const double w = place - std::floor(place);
      gripline::RefPoint& r = horizon[k];
      r.s = place / static_cast<double>(line_.size()) * length;  // a station of line_
      r.x = p.x + w * (q.x - p.x), r.y = p.y + w * (q.y - p.y), r.v = speed_, r.beta = 0;
      r.yaw = p.yaw + w * std::remainder(q.yaw - p.yaw, 2 * pi) + (side < 0 ? pi : 0);  // against the file: turned
      r.kappa = side * p.kappa, r.left = side > 0 ? p.left : p.right, r.right = side > 0 ? p.right : p.left;
      const gripline::CoursePoint c = course_.locate(r.x, r.y, p.station);  // of the centre line, in file order
      const double t = now.t + static_cast<double>(k) * dt_, grade = side * c.grade, bank = side * c.bank;
      r.at = {t, c.s, c.n, c.lap_fraction, c.yaw, c.kappa, grade, bank, side};  // slopes as the car drives
    }
  }
  std::span<const gripline::LinePoint> line() const override { return line_; }

 private:
  double speed_, dt_;
  const gripline::Course& course_;
  std::vector<gripline::LinePoint> line_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "line of least curvature at a constant speed"))
