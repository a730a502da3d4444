#include "measured/table/earth_places.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "measured/table/placeholder_places.hpp"
#include "tables/refuse_file.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;

void note(std::vector<Finding>& findings, std::string check, std::string found, std::string done) {
  findings.push_back({Finding::Level::note, std::move(check), std::move(found), std::move(done)});
}

/// Receivers write 0, 0 as long as they do not know where they are.
void drop_places_without_fix(EarthPlaces& places, std::vector<Finding>& findings) {
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < places.latitude.size(); ++i) {
    if (places.latitude[i] != 0.0 || places.longitude[i] != 0.0) continue;
    places.latitude[i] = places.longitude[i] = not_a_number;
    ++dropped;
  }
  if (dropped > 0)
    note(findings, "place", std::to_string(dropped) + " rows have the latitude and longitude 0, 0",
         "taken for missing: the receiver had no fix");
}

/// The plane lies where the car is, not where the receiver was the day before.
void drop_places_of_before(EarthPlaces& places, std::vector<Finding>& findings) {
  if (places.t.size() != places.latitude.size()) return;
  const PlaceholderPlaces dropped = drop_placeholder_places(places.t, places.latitude, places.longitude);
  if (dropped.rows == 0) return;
  constexpr double degree = pi / 180.0;
  note(findings, "place",
       std::to_string(dropped.rows) + " rows at the beginning show the latitude and longitude " +
           significant(dropped.x / degree, 6) + ", " + significant(dropped.y / degree, 6) + " deg, far from the rest",
       "taken for missing: there was no fix yet");
}

/// Maps and tables often leave the unit out.
void take_for_degrees(EarthPlaces& places, std::vector<Finding>& findings) {
  const auto beyond = [](const std::vector<double>& angles, bool known, double most) {
    return !known && std::ranges::any_of(angles, [most](double a) { return std::abs(a) > most; });
  };
  if (!beyond(places.latitude, places.latitude_unit_is_known, 0.5 * pi) &&
      !beyond(places.longitude, places.longitude_unit_is_known, pi))
    return;
  const auto convert = [](std::vector<double>& angles, bool known) {
    if (known) return;
    for (double& angle : angles) angle *= pi / 180.0;
  };
  convert(places.latitude, places.latitude_unit_is_known);
  convert(places.longitude, places.longitude_unit_is_known);
  note(findings, "unit", "latitude and longitude are beyond what radians can be",
       "taken for degrees; `unit` in the map says so");
}

void check_latitudes(const EarthPlaces& places, const std::filesystem::path& file, std::span<const int> line) {
  const std::vector<double>& lat = places.latitude;
  const auto wrong = std::ranges::find_if(lat, [](double a) { return std::abs(a) > 0.5 * pi + 1e-9; });
  if (wrong == lat.end()) return;
  refuse_file(file,
              "the latitude is " + significant(*wrong * 180.0 / pi, 6) +
                  " deg, beyond 90: NMEA's ddmm.mmmm are degrees and minutes ((v - mod(v, 100)) / 100 + mod(v, 100) "
                  "/ 60 in deg)",
              line[static_cast<std::size_t>(wrong - lat.begin())]);
}

}  // namespace

PlanePlaces on_plane(EarthPlaces places, const std::filesystem::path& file, std::span<const int> line,
                     std::vector<Finding>& findings) {
  drop_places_without_fix(places, findings);
  take_for_degrees(places, findings);
  check_latitudes(places, file, line);
  drop_places_of_before(places, findings);
  const std::vector<double>&lat = places.latitude, &lon = places.longitude;
  std::size_t first = 0;
  while (first < lat.size() && std::isnan(lat[first] + lon[first])) ++first;
  if (first == lat.size()) refuse_file(file, "latitude and longitude are never given");
  // Radii of curvature along the meridian and across it at that latitude; the second times its cosine.
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double w = 1.0 - e2 * std::sin(lat[first]) * std::sin(lat[first]);
  const double north = a * (1.0 - e2) / (w * std::sqrt(w)), east = a / std::sqrt(w) * std::cos(lat[first]);
  PlanePlaces out;
  for (std::size_t i = 0; i < lat.size(); ++i) {
    const bool known = !std::isnan(lat[i] + lon[i]);
    out.x.push_back(known ? east * std::remainder(lon[i] - lon[first], 2.0 * pi) : not_a_number);
    out.y.push_back(known ? north * (lat[i] - lat[first]) : not_a_number);
  }
  note(findings, "place", "latitude and longitude", "x to the east and y to the north of the first position");
  return out;
}

}  // namespace gripline::measured
