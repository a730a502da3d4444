// interfaces.hpp: `const` calls may come from several threads at once. Each is made from four, on buffers of their own,
// and gives what it gives alone; the preset tsan watches them do it.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <thread>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/effect_bench.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_const_calls {

constexpr int threads = 4, calls = 25;

/// Whether `answer` gives the same numbers from every thread as alone.
void expect_same_from_threads(const std::string& what, const std::function<std::vector<double>()>& answer) {
  const std::vector<double> alone = answer();
  ASSERT_FALSE(alone.empty()) << what;
  std::vector<int> differences(threads, 0);
  {
    std::vector<std::jthread> workers;
    for (int& count : differences)
      workers.emplace_back([&alone, &answer, &count] {
        for (int i = 0; i < calls; ++i) {
          const std::vector<double> now = answer();
          const bool same =
              now.size() == alone.size() && std::memcmp(now.data(), alone.data(), now.size() * sizeof(double)) == 0;
          if (!same) ++count;
        }
      });
  }
  for (const int count : differences) EXPECT_EQ(count, 0) << what;
}

/// Values and derivatives of quantities or readings, as one row of numbers.
template <class Numbers>
std::vector<double> numbers_of(const std::vector<Numbers>& all) {
  std::vector<double> numbers(all.size() * sizeof(Numbers) / sizeof(double));
  std::memcpy(numbers.data(), static_cast<const void*>(all.data()), numbers.size() * sizeof(double));
  return numbers;
}

/// Five instants in a corner, with all that an effect or a model may look at.
template <class T>
struct Batch {
  static constexpr std::size_t n = 5;
  std::vector<Quantities<T>> q;
  std::vector<Reading<T>> readings = std::vector<Reading<T>>(n);
  std::vector<Place> at{n};
  std::vector<T> params, memory, memory_rate;
  std::vector<CommandSample<T>> commands{{T(0.1), T(0.0)}, {T(0.3), T(0.05)}, {T(0.5), T(0.1)}};
  std::vector<History<T>> history;

  Batch(const PluginEntry& entry, int memory_size) : q(n, test::lift<T>(test::bench_quantities())) {
    for (const abi::ParamDecl& p : entry.params()) {
      T value = T(p.fit ? p.start : p.default_value);
      if constexpr (std::is_same_v<T, Dual8>) value.d[params.size() % 8] = 1.0;
      params.push_back(value);
    }
    for (std::size_t i = 0; i < n; ++i) {
      q[i].vx += T(0.3 * static_cast<double>(i));
      at[i].t = static_cast<double>(i);
      at[i].lap_fraction = 0.2 * static_cast<double>(i);
      readings[i].vx = T(1.0 + 0.3 * static_cast<double>(i));
      history.push_back({commands.data(), commands.size(), 0.0, 0.02, 0.04, Hold::foh});
    }
    memory.assign(n * static_cast<std::size_t>(memory_size), T(0.01));
    memory_rate.assign(memory.size(), T(0.0));
  }
  Points<T> points(int memory_size, Stage stage) {
    const bool read = stage == Stage::reading;
    return {n,
            read ? nullptr : q.data(),
            at.data(),
            params.data(),
            memory.data(),
            memory_rate.data(),
            static_cast<std::size_t>(memory_size),
            history.data(),
            read ? readings.data() : nullptr};
  }
};

template <class T>
std::vector<double> applied(const Effect& effect, const PluginEntry& entry) {
  Batch<T> batch(entry, effect.memory());
  effect.apply(batch.points(effect.memory(), effect.stage()));
  std::vector<double> numbers = effect.stage() == Stage::reading ? numbers_of(batch.readings) : numbers_of(batch.q);
  for (const T& rate : batch.memory_rate) numbers.push_back(value(rate));
  return numbers;
}

TEST(ConstCalls, EffectsAndModels) {
  std::size_t seen = 0;
  for (const PluginEntry& entry : test::plugins().entries()) {
    std::vector<abi::ParamValue> values;
    for (const abi::ParamDecl& p : entry.params()) values.push_back({p.fit ? p.start : p.default_value, Table{}});
    const std::string id = entry.decl->id;
    if (entry.decl->kind == abi::Kind::effect) {
      const auto effect = create<Effect>(entry, test::bench_car(), values);
      expect_same_from_threads(id, [&] { return applied<double>(*effect, entry); });
      expect_same_from_threads(id, [&] { return applied<Dual8>(*effect, entry); });
      ++seen;
    } else if (entry.decl->kind == abi::Kind::vehicle) {
      const auto model = create<VehicleModel>(entry, test::bench_car(), values);
      const auto evaluated = [&]<class T>(T) {
        Batch<T> batch(entry, 0);
        model->evaluate(Stage::command, Stage::body, batch.points(0, Stage::body));
        return numbers_of(batch.q);
      };
      expect_same_from_threads(id, [&] { return evaluated(0.0); });
      expect_same_from_threads(id, [&] { return evaluated(Dual8(0.0)); });
      ++seen;
    }
  }
  EXPECT_GT(seen, 20u);
}

TEST(ConstCalls, EstimatorsThatLearned) {
  const rig::Drive drive = rig::drive_bends(6, 3, [](double) { return 1.0; });
  for (const char* id : {"none", "elm", "elm_rls", "gp_own_mu", "lla", "mhe"}) {
    rig::Nominal nominal("ekinematic");
    const auto estimator = rig::make_estimator(id, nominal);
    rig::learn(*estimator, nominal, drive);
    const PluginEntry& entry = rig::registry().find(abi::Kind::estimator, id);
    expect_same_from_threads(id, [&] { return applied<double>(*estimator, entry); });
    expect_same_from_threads(id, [&] { return applied<Dual8>(*estimator, entry); });
    expect_same_from_threads(id, [&] {
      const Belief belief = estimator->belief();
      std::vector<double> numbers = {belief.mu_front, belief.mu_rear, belief.sigma_front, belief.sigma_rear};
      const std::vector<double> slip = {-0.2, -0.05, 0.0, 0.1, 0.3};
      for (const Axle axle : {Axle::front, Axle::rear}) {
        std::vector<double> force(slip.size()), sigma(slip.size());
        numbers.push_back(estimator->tyre_force(axle, slip, force, sigma) ? 1 : 0);
        numbers.insert(numbers.end(), force.begin(), force.end());
        numbers.insert(numbers.end(), sigma.begin(), sigma.end());
      }
      return numbers;
    });
  }
}

TEST(ConstCalls, TheRoadAndTheRegistry) {
  const Track track = load_track(testing_support::source_dir() / "worlds/tracks/ethz.json");
  expect_same_from_threads("track", [&] {
    std::vector<double> numbers;
    for (int i = 0; i < 50; ++i) {
      const CurvePoint p = track.at(track.length() * i / 50);
      numbers.insert(numbers.end(), {p.x, p.y, p.yaw, track.half_width_left(p.s), track.half_width_right(p.s)});
    }
    return numbers;
  });
  expect_same_from_threads("registry", [] {
    const PluginEntry& entry = test::plugins().find(abi::Kind::vehicle, "dynamic");
    return std::vector<double>{static_cast<double>(entry.params().size())};
  });
}

}  // namespace test_const_calls
}  // namespace gripline
