#include "limit/envelope_car.hpp"

#include <algorithm>
#include <cmath>

#include "world/friction.hpp"

namespace gripline {
namespace {

PlantEnvelope envelope_of(const WorldSpec& spec, double factor) {
  const auto plant = create<Plant>(*spec.plant.entry, plugin_context(spec), spec.plant.values);
  return measure_envelope(*plant, spec.car.car, spec.dt, factor);
}

FrictionSchedule patches_alone(const WorldSpec& spec, bool patches) {
  if (!patches) return {};
  FrictionSpec friction;
  friction.patches = spec.friction.patches;
  return {friction, spec.dt};
}

/// `hold`, bent so that it nowhere falls below `least` [m/s2]; itself from twice that on. Once differentiable.
Dual8 no_less(const Dual8& hold, double least) {
  if (hold.v >= 2.0 * least) return hold;
  return hold.v > 0 ? least + hold * hold * (0.25 / least) : Dual8(least);
}

}  // namespace

EnvelopeCar::EnvelopeCar(const WorldSpec& spec, double factor, bool patches)
    : EnvelopeCar(spec, envelope_of(spec, factor), patches) {}

EnvelopeCar::EnvelopeCar(const WorldSpec& spec, PlantEnvelope envelope, bool patches)
    : spec_(spec), envelope_(std::move(envelope)), patches_(patches_alone(spec, patches)) {
  const Track& track = *spec.track;
  const double wheelbase = car().lf + car().lr;
  const auto count = static_cast<std::size_t>(std::ceil(track.length() / wheelbase));
  for (std::size_t i = 0; i < count; ++i) {
    const double s = track.length() * static_cast<double>(i) / static_cast<double>(count);
    const double ahead = track.wrap(s + 0.5 * wheelbase), behind = track.wrap(s - 0.5 * wheelbase);
    curve_.push_back((track.grade(ahead) - track.grade(behind)) / wheelbase +
                     track.at(s).kappa * std::sin(track.bank(s)));
  }
}

double EnvelopeCar::curve_at(double station) const {
  const auto count = static_cast<double>(curve_.size());
  const double x = spec_.track->wrap(station) / spec_.track->length() * count;
  const auto i = std::min(static_cast<std::size_t>(x), curve_.size() - 1);
  const double share = x - static_cast<double>(i);
  return (1.0 - share) * curve_[i] + share * curve_[i + 1 < curve_.size() ? i + 1 : 0];
}

double EnvelopeCar::mu() const {
  double least = 1.0;
  for (const FrictionSpec::Patch& patch : spec_.friction.patches)
    least = std::min({least, patch_at(patch.from_s), patch_at(patch.to_s)});
  return least * envelope_.side.weight / gravity;
}

/// What the commands give, of which one is zero.
template <class T>
T EnvelopeCar::driven(const T& v, const T& d) const {
  const T share = value(d) >= 0 ? d * (1.0 / car().d_max) : d * (-1.0 / car().d_min);
  return (value(d) >= 0 ? envelope_.throttle : envelope_.brakes).at(v) * share;
}

double EnvelopeCar::acceleration(double v, double d) const { return driven(v, d) + envelope_.rolling.at(v); }

void EnvelopeCar::lap_rates(std::span<const Dual8> motion, std::span<const ActingCommand<Dual8>> command,
                            std::span<const Place> at, std::span<Dual8> rate) const {
  constexpr double settles = 10;  // wheelbases in which yaw rate and steering agree
  const double wheelbase = car().lf + car().lr;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const Dual8* const x = motion.data() + i * motion_size;
    const ActingCommand<Dual8>& u = command[i];
    const Dual8 &v = x[3], &vy = x[4], &omega = x[5];
    const Dual8 across = v * omega - gravity * std::sin(at[i].bank);
    const Dual8 along =
        driven(v, u.d) + envelope_.rolling.at(v) - envelope_.bend * across * across - gravity * std::sin(at[i].grade);
    const Dual8 settling = v * (1.0 / (settles * wheelbase));
    Dual8* const r = rate.data() + i * motion_size;
    r[0] = r[1] = Dual8(0.0);
    r[2] = omega;
    r[3] = along;
    r[4] = -settling * vy;
    r[5] =
        (along * u.delta + v * u.delta_rate) * (1.0 / wheelbase) + settling * (v * u.delta * (1.0 / wheelbase) - omega);
  }
}

Dual8 EnvelopeCar::used(const Dual8& v, const Dual8& omega, const Dual8& throttle, const Dual8& brake,
                        const Place& at) const {
  constexpr double smooth = 1e-4;      // of used, where nothing is used
  constexpr double in_the_air = 1e-2;  // of the weight: what tyres hold at least, so that faster is never less use
  const double grade = std::sin(at.grade), bank = std::sin(at.bank);
  const double flat = std::sqrt(std::max(0.0, 1.0 - grade * grade - bank * bank));
  const double curve = curve_at(at.s), patch = patch_at(at.s);
  const auto share = [&](const Dual8& a, const TyreHold& hold) {
    const Dual8 all = hold.weight * (flat + (curve / gravity) * v * v) + hold.downforce * v * v;
    return a / (patch * no_less(all, in_the_air * hold.weight * flat));
  };
  const auto power = [&](const Dual8& squared) { return exp(0.5 * envelope_.shape * log(squared + smooth)); };
  const Dual8 across = share(v * omega - gravity * bank, envelope_.side);
  const Dual8 drive = share(driven(v, throttle), envelope_.drive), stop = share(driven(v, brake), envelope_.brake);
  return power(across * across) + power(drive * drive + stop * stop);
}

}  // namespace gripline
