#include "limit/lap_mesh.hpp"

#include "geometry/course_adapter.hpp"
#include "geometry/plane.hpp"

namespace gripline {

LapMesh make_mesh(const Track& track, std::vector<double> stations) {
  LapMesh mesh;
  mesh.s = std::move(stations);
  for (std::size_t k = 0; k < mesh.s.size(); ++k) {
    const double s = mesh.s[k], end = k + 1 < mesh.s.size() ? mesh.s[k + 1] : mesh.s[0] + track.length();
    const double middle = track.wrap(0.5 * (s + end));
    mesh.ds.push_back(end - s);
    const double turned = wrap_angle(track.at(track.wrap(end)).yaw - track.at(s).yaw);
    mesh.kappa.push_back(turned / (end - s));
    mesh.n_lo.push_back(-track.half_width_right(s));
    mesh.n_hi.push_back(track.half_width_left(s));
    mesh.mid_lo.push_back(-track.half_width_right(middle));
    mesh.mid_hi.push_back(track.half_width_left(middle));
    const CurvePoint p = track.at(middle);
    mesh.places.push_back(place_of(track, {middle, 0.0, p.yaw, p.kappa}, 0.0, p.x, p.y, p.yaw));
  }
  return mesh;
}

LapMesh halved(const Track& track, const LapMesh& mesh) {
  std::vector<double> stations;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    stations.push_back(mesh.s[k]);
    stations.push_back(mesh.s[k] + 0.5 * mesh.ds[k]);
  }
  return make_mesh(track, std::move(stations));
}

Lap halved(const Lap& lap) {
  Lap finer;
  for (std::size_t k = 0; k < lap.z.size(); ++k) {
    const auto &here = lap.z[k], &next = lap.z[k + 1 < lap.z.size() ? k + 1 : 0];
    auto middle = here;
    for (std::size_t j = 0; j < lap_states; ++j) middle[j] = 0.5 * (here[j] + next[j]);
    finer.z.push_back(here);
    finer.z.push_back(middle);
  }
  return finer;
}

}  // namespace gripline
