#include "measured/session/guess_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "config/units.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/guess_heading.hpp"
#include "measured/table/formula.hpp"
#include "tables/column_names.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;
using Values = std::vector<double>;

/// Channel by channel; headings and speeds against the path of the places.
class MotionGuess {
 public:
  explicit MotionGuess(GuessDraft& draft) : draft_(draft) {}

  void run() {
    const bool place = draft_.column("x") >= 0 && draft_.column("y") >= 0;  // one without the other is none
    for (const char* name : {"x", "y"})
      if (place) draft_.guess_column(name, "m");
    if (!place) guess_earth_places();
    guess_yaw();
    for (const char* name : {"vx", "vy"}) draft_.guess_column(name, "m/s");
    check_speed_unit();
    guess_yaw_rate();
    hold_repeated();
  }

 private:
  void guess_earth_places() {
    const int lat = draft_.column("latitude"), lon = draft_.column("longitude");
    if (lat < 0 || lon < 0) return;
    draft_.channels.set("latitude", guessed_channel("column", draft_.name(lat), "deg"));
    draft_.channels.set("longitude", guessed_channel("column", draft_.name(lon), "deg"));
    lat_ = lat, lon_ = lon;
  }

  /// Where the place is read: x and y, or neither where it is latitude and longitude.
  struct PlaceColumns {
    const Values *x = nullptr, *y = nullptr;
    double metres = 1.0;  // that 1 of them is
  };
  /// Looked up once for all rows: a look reads whole columns.
  PlaceColumns place_columns() const {
    if (!draft_.found("x") || !draft_.found("y")) return {};
    return {&draft_.values(draft_.column("x")), &draft_.values(draft_.column("y")),
            to_si("1 " + draft_.channels.find("x")->find("unit")->text(), "m")};
  }
  /// Whether a row's place is another than that of the row before.
  bool is_new(const PlaceColumns& place, std::size_t i) const {
    if (place.x == nullptr && lat_ < 0) return false;
    const Values &x = place.x != nullptr ? *place.x : draft_.values(lon_),
                 &y = place.y != nullptr ? *place.y : draft_.values(lat_);
    return std::isfinite(x[i] + y[i]) && (x[i] != x[i - 1] || y[i] != y[i - 1]);
  }
  /// Way from row to row [m], for comparisons with headings and speeds.
  bool way(const PlaceColumns& place, std::size_t i, std::size_t j, double& dx, double& dy) const {
    if (place.x != nullptr) {
      dx = place.metres * ((*place.x)[j] - (*place.x)[i]);
      dy = place.metres * ((*place.y)[j] - (*place.y)[i]);
    } else if (lat_ >= 0) {
      constexpr double metres = 111195.0;  // per degree
      dx = metres * std::cos(draft_.values(lat_)[i] * pi / 180) * (draft_.values(lon_)[j] - draft_.values(lon_)[i]);
      dy = metres * (draft_.values(lat_)[j] - draft_.values(lat_)[i]);
    } else {
      return false;
    }
    return std::isfinite(dx + dy) && std::hypot(dx, dy) > 0.05;
  }

  /// Sums over the path of what is added to a heading, and to the heading counted the other way round, to give the
  /// path's own: sine and cosine of both.
  struct AgainstPath {
    double sine = 0, cosine = 0, mirrored_sine = 0, mirrored_cosine = 0, rows = 0;
    /// How steady the better of both is: the length of its sum.
    double agreement() const { return std::max(std::hypot(sine, cosine), std::hypot(mirrored_sine, mirrored_cosine)); }
    bool counts_clockwise() const { return std::hypot(mirrored_sine, mirrored_cosine) > std::hypot(sine, cosine); }
  };
  AgainstPath against_path(const Values& heading, double factor) const {
    AgainstPath sum;
    const PlaceColumns place = place_columns();
    double dx = 0, dy = 0;
    for (std::size_t i = 0; i + window < draft_.table.rows(); i += window)
      if (way(place, i, i + window, dx, dy) && std::isfinite(heading[i])) {
        const double a = factor * heading[i], path = std::atan2(dy, dx);
        sum.sine += std::sin(path - a), sum.cosine += std::cos(path - a);
        sum.mirrored_sine += std::sin(path + a), sum.mirrored_cosine += std::cos(path + a), sum.rows += 1;
      }
    return sum;
  }
  /// Whether a heading is in degrees. Where no unit is stated: values beyond a turn are, unless they agree better with
  /// the path as radians that were counted on over turns.
  bool is_in_degrees(int c) {
    if (draft_.unit_of(c, "rad") == "deg") return true;
    if (!draft_.table.unit[static_cast<std::size_t>(c)].empty() || quantile_of_size(draft_.values(c), 0.99) <= 7.0)
      return false;
    const Values& heading = draft_.values(c);
    return against_path(heading, pi / 180).agreement() >= against_path(heading, 1.0).agreement();
  }

  /// A course is no heading. Where there is a place, reading the log makes one of it and knows it for a course, so that
  /// no delay is found against it; alone it stands in for the yaw. Returns whether it does not.
  bool leaves_course_out(int c) {
    if (!is_called_course(draft_.known_as(static_cast<std::size_t>(c)))) return false;
    const bool place = draft_.found("x") || lat_ >= 0;
    draft_.remarks.push_back("yaw: " + draft_.name(c) +
                             " is the course of the velocity, which differs from the yaw by the sideslip" +
                             (place ? "; it is not used, as the place shows the course too"
                                    : "; taken in its place, as nothing else shows where the car points"));
    return place;
  }

  void judge_heading(const AgainstPath& path, const std::string& name) {
    follows_path_ = path.agreement() >= 0.8 * path.rows;
    if (!follows_path_) draft_.remarks.push_back("yaw: " + name + " follows the path badly; is it the heading?");
  }
  /// The yaw of the quaternion that poses of ROS have. Returns whether there is one.
  bool guess_yaw_of_quaternion() {
    const auto find = [&](const char* word) {
      for (std::size_t c = 0; c < draft_.table.name.size(); ++c)
        if (const std::string& name = draft_.known_as(c);
            is_called(name, word, nullptr) || (is_called_in_path(name, word, nullptr) && !is_path_of_command(name)))
          return static_cast<int>(c);
      return -1;
    };
    const int x = find("orientationx"), y = find("orientationy"), z = find("orientationz"), w = find("orientationw");
    if (z < 0 || w < 0 || !draft_.varies(static_cast<std::size_t>(z))) return false;
    for (const int c : {x, y, z, w})
      if (c >= 0 && draft_.name(c).find('`') != std::string::npos) return false;  // no formula can name it
    const std::string qz = draft_.quoted(z), qw = draft_.quoted(w);
    std::string formula = "2 * atan2(" + qz + ", " + qw + ")";
    if (x >= 0 && y >= 0) {
      const std::string qx = draft_.quoted(x), qy = draft_.quoted(y);
      formula = "atan2(2 * (" + qw + " * " + qz + " + " + qx + " * " + qy + "), 1 - 2 * (" + qy + " * " + qy + " + " +
                qz + " * " + qz + "))";
    }
    const AgainstPath path = against_path(Formula(formula, draft_.table, "yaw").evaluate(draft_.table, {}), 1.0);
    if (path.rows > 20) judge_heading(path, draft_.name(z));
    yaw_ = z;
    draft_.channels.set("yaw", guessed_channel("formula", formula, "rad"));
    return true;
  }

  /// Heading against the path: which of yaw, compass, degrees or radians is it?
  void guess_yaw() {
    const int c = draft_.column("yaw");
    const bool heading = c >= 0 && !is_called_course(draft_.known_as(static_cast<std::size_t>(c)));
    if (!heading && guess_yaw_of_quaternion()) return;
    if (c < 0 || leaves_course_out(c)) return;
    yaw_ = c;
    const bool deg = is_in_degrees(c);
    const std::string angle = deg ? "rad(" + draft_.quoted(c) + ")" : draft_.quoted(c);
    const AgainstPath path = against_path(draft_.values(c), deg ? pi / 180 : 1.0);
    std::string formula = angle;
    if (path.rows > 20) {
      const bool compass = path.counts_clockwise();
      const double offset =
          compass ? std::atan2(path.mirrored_sine, path.mirrored_cosine) : std::atan2(path.sine, path.cosine);
      const double quarter = std::round(offset / (pi / 2)) * (pi / 2);
      const std::string add = quarter == 0 ? "" : std::abs(quarter) > 3 ? "pi" : quarter > 0 ? "pi/2" : "-pi/2";
      if (compass)
        formula = (add.empty() ? "-" : add + " - ") + angle;
      else if (!add.empty())
        formula = angle + " + " + add;
      if (formula != angle)
        draft_.remarks.push_back("yaw: " + draft_.name(c) + (compass ? " counts clockwise" : " is turned") +
                                 " against the path");
      judge_heading(path, draft_.name(c));
    }
    draft_.channels.set("yaw", formula == draft_.quoted(c) && !deg ? guessed_channel("column", draft_.name(c), "rad")
                               : formula == angle && deg           ? guessed_channel("column", draft_.name(c), "deg")
                                                                   : guessed_channel("formula", formula, "rad"));
  }

  /// The speed over that of the path, in windows that begin and end where the place is new: loggers repeat it until
  /// the next one is read.
  Values ratios_to_path(int c) const {
    const Values& t = draft_.values(draft_.column("time"));
    const double second = to_si("1 " + draft_.time.find("unit")->text(), "s");
    const PlaceColumns place = place_columns();
    const double enough = 0.3 * quantile_of_size(draft_.values(c), 0.95);
    Values ratios;
    double dx = 0, dy = 0;
    std::size_t from = draft_.table.rows();
    for (std::size_t i = 1; i < draft_.table.rows(); ++i) {
      if (!is_new(place, i) || (from < i && i - from < window)) continue;
      if (from < i && way(place, from, i, dx, dy) && std::abs(draft_.values(c)[from]) > enough && t[i] > t[from])
        ratios.push_back(draft_.values(c)[from] / (std::hypot(dx, dy) / (second * (t[i] - t[from]))));
      from = i;
    }
    return ratios;
  }

  /// A speed without a unit, against the path.
  void check_speed_unit() {
    const int c = draft_.column("vx");
    if (c < 0 || draft_.column("time") < 0 || !draft_.table.unit[static_cast<std::size_t>(c)].empty()) return;
    constexpr std::size_t few = 20;
    const Values ratios = ratios_to_path(c);
    const std::string taken = draft_.channels.find("vx")->find("unit")->text();
    const bool told = !draft_.unit_of_name(c, "m/s").empty();
    if (ratios.size() < few) {
      if (!told)
        draft_.remarks.push_back(
            "vx: no unit is written, and the place identifies none (it changes too seldom); taken for " + taken);
      return;
    }
    const double ratio = quantile_of_size(ratios, 0.5), expected = 1.0 / to_si("1 " + taken, "m/s");
    const std::string found = "vx: " + significant(ratio) + " times the speed of the path";
    if (told && is_about(ratio, expected)) return;
    for (const WrongUnit& wrong : wrong_units)
      if (!wrong.of_place && ratio > wrong.low && ratio < wrong.high) {
        if (!told) draft_.channels.set("vx", guessed_channel("column", draft_.name(c), wrong.unit));
        draft_.remarks.push_back(found + (told ? ", which looks like " : ", taken for ") + wrong.unit +
                                 (told ? "; its name says " + taken : ""));
        return;
      }
    if (!is_about(ratio, expected)) draft_.remarks.push_back(found + "; this does not identify its unit");
  }

  void guess_yaw_rate() {
    const int c = draft_.column("yaw_rate");
    if (c < 0) return;
    std::string unit = draft_.unit_of(c, "rad/s");
    if (unit == "rad/s" && draft_.table.unit[static_cast<std::size_t>(c)].empty() &&
        quantile_of_size(draft_.values(c), 0.98) > 12) {
      unit = "deg/s";
      draft_.remarks.push_back("yaw_rate: values of " + significant(quantile_of_size(draft_.values(c), 0.98)) +
                               ", taken for deg/s");
    }
    Node node = guessed_channel("column", draft_.name(c), unit);
    if (turns_against_heading(c)) {
      node.set("sign", Node(-1.0));
      draft_.remarks.push_back("yaw_rate: positive to the right; its sign is turned");
      turn_lateral_velocity();
    }
    draft_.channels.set("yaw_rate", std::move(node));
  }
  /// Where the path tells how the heading counts: so does the yaw rate, or the other way round.
  bool turns_against_heading(int c) const {
    constexpr double clearly = -0.7;
    return follows_path_ && heading_follows(draft_, c).value() < clearly;
  }
  /// u, v and r are of one frame: of a yaw rate that is positive to the right, v is too.
  void turn_lateral_velocity() {
    const Node* const vy = draft_.channels.find("vy");
    if (vy == nullptr || !draft_.has_u_and_v()) return;
    Node node = *vy;
    node.set("sign", Node(-1.0));
    draft_.channels.set("vy", std::move(node));
    draft_.remarks.push_back("vy: positive to the right as the yaw rate; its sign is turned");
  }

  /// Readings that the logger repeats until there is a new one.
  void hold_repeated() {
    for (const char* channel : {"x", "y", "latitude", "longitude", "yaw", "vx", "vy", "yaw_rate"}) {
      const Node* const found = draft_.channels.find(channel);
      if (found == nullptr) continue;
      const int c = channel == std::string_view("yaw") ? yaw_ : draft_.column(channel);
      const double every = draft_.rows_between_new_values(c);
      if (!(every > 1.0)) continue;
      Node node = *found;
      node.set("hold", Node("held"));
      draft_.channels.set(channel, std::move(node));
      draft_.remarks.push_back(std::string(channel) + ": a new value every " + significant(every) +
                               " rows; read when it is new");
    }
  }

  static constexpr std::size_t window = 10;  // rows over which headings and speeds are compared with the path
  GuessDraft& draft_;
  int lat_ = -1, lon_ = -1;
  int yaw_ = -1;               // of a quaternion the z
  bool follows_path_ = false;  // the yaw
};

}  // namespace

void guess_motion(GuessDraft& draft) { MotionGuess(draft).run(); }

}  // namespace gripline::measured
