#include "linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gripline::diagnose {
namespace {

/// Rates by up to eight directions of the parameters at every sample: row k holds 3 x 8.
/// `seed` lists the parameters of the car that carry directions 0, 1, ...
struct DualPass {
  const StagedCar& car;
  const Trace& trace;
  const std::vector<double>& memory;

  template <class Sink>
  void run(std::span<const std::size_t> seed, bool by_state, Sink&& sink) const {
    const auto m = static_cast<std::size_t>(car.memory());
    const std::size_t n = trace.size();
    std::vector<Dual8> params(car.params().begin(), car.params().end());
    for (std::size_t i = 0; i < seed.size(); ++i) params[seed[i]].d[i] = 1.0;
    constexpr std::size_t chunk = 8;
    std::vector<Dual8> x(chunk * channels), rate(x.size()), mem(chunk * m), mem_rate(mem.size());
    std::array<ActingCommand<Dual8>, chunk> command;
    std::array<History<Dual8>, chunk> history;
    CarBatch<Dual8> batch;
    batch.params = params.data();
    batch.motion = x.data();
    batch.motion_rate = rate.data();
    batch.memory = mem.data();
    batch.memory_rate = mem_rate.data();
    batch.command = command.data();
    batch.history = history.data();
    for (std::size_t begin = 0; begin < n; begin += chunk) {
      batch.n = std::min(chunk, n - begin);
      batch.at = trace.at.data() + begin;
      for (std::size_t i = 0; i < batch.n; ++i) {
        const std::size_t k = begin + i;
        for (std::size_t c = 0; c < channels; ++c) {
          x[i * channels + c] = Dual8(trace.motion[k * channels + c]);
          if (by_state && c >= 2) x[i * channels + c].d[c - 2] = 1.0;
        }
        for (std::size_t j = 0; j < m; ++j) {
          mem[i * m + j] = Dual8(memory[k * m + j]);
          if (by_state && j < 4) mem[i * m + j].d[4 + j] = 1.0;
        }
        const auto c = trace.command(k, 0.0);
        command[i] = {Dual8(c.d), Dual8(c.delta), Dual8(c.delta_rate)};
        history[i] = {trace.command_dual.data(), n, trace.log.t0, trace.log.dt, trace.at[k].t, Hold::foh};
      }
      car.rates(batch);
      for (std::size_t i = 0; i < batch.n; ++i) sink(begin + i, rate.data() + i * channels, mem_rate.data() + i * m);
    }
  }
};

/// Readings by the parameters in `seed` (or, by_state, by the six states) at every sample.
template <class Sink>
void read_pass(const StagedCar& car, const Trace& trace, std::span<const std::size_t> seed, bool by_state,
               Sink&& sink) {
  std::vector<Dual8> params(car.params().begin(), car.params().end());
  for (std::size_t i = 0; i < seed.size(); ++i) params[seed[i]].d[i] = 1.0;
  for (std::size_t k = 0; k < trace.size(); ++k) {
    std::array<Dual8, channels> v;
    for (std::size_t c = 0; c < channels; ++c) {
      v[c] = Dual8(trace.motion[k * channels + c]);
      if (by_state) v[c].d[c] = 1.0;
    }
    Reading<Dual8> r{v[0], v[1], v[2], v[3], v[4], v[5]};
    car.read(&r, 1, &trace.at[k], params.data());
    const std::array<Dual8, channels> out{r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
    sink(k, out);
  }
}

bool reads(const Catalogue& catalogue, const ModelSpec& model) {
  return std::any_of(model.members.begin(), model.members.end(),
                     [&](std::size_t i) { return catalogue.candidates()[i].effect->stage() == Stage::reading; });
}

/// F = exp(h A) and the weights of an input that is linear in time: with P1 = h sum (hA)^i / (i+1)! and
/// P2 = h sum (hA)^i / (i+2)!, an input b0 at the start and b1 at the end adds (P1 - P2) b0 + P2 b1.
template <std::size_t N>
void exponentials(const double* A, double h, double* F, double* in0, double* in1) {
  // Power series by rows; P1 and P2 need the three columns 3..5. Nothing depends on x and y, so that columns begin with
  // the yaw; the unknown accelerations only fade.
  constexpr int order = 7;
  constexpr std::size_t body = N - noise_states, columns = N - 2;
  double term[body][columns] = {}, sum[body][columns] = {}, p1[body][3] = {}, p2[body][3] = {};
  double fading[noise_states];
  for (std::size_t i = 2; i < body; ++i) term[i][i - 2] = sum[i][i - 2] = 1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    p1[3 + c][c] = h;
    p2[3 + c][c] = 0.5 * h;
    fading[c] = 1.0;
  }
  double factorial = 1.0;
  for (int k = 1; k <= order; ++k) {
    double next[body][columns] = {};
    for (std::size_t i = 0; i < body; ++i) {
      for (std::size_t l = 2; l < body; ++l) {
        const double a = A[i * N + l] * h;
        if (a == 0.0) continue;
        for (std::size_t j = 0; j < columns; ++j) next[i][j] += a * term[l][j];
      }
      for (std::size_t c = 0; c < noise_states; ++c) next[i][body + c - 2] += A[i * N + body + c] * h * fading[c];
    }
    for (std::size_t c = 0; c < noise_states; ++c) fading[c] *= A[(body + c) * (N + 1)] * h;
    factorial *= k;
    const double f0 = 1.0 / factorial, f1 = h / (factorial * (k + 1)), f2 = h / (factorial * (k + 1) * (k + 2));
    for (std::size_t i = 0; i < body; ++i) {
      for (std::size_t j = 0; j < columns; ++j) {
        term[i][j] = next[i][j];
        sum[i][j] += f0 * next[i][j];
      }
      for (std::size_t c = 0; c < 3; ++c) {
        p1[i][c] += f1 * next[i][1 + c];
        p2[i][c] += f2 * next[i][1 + c];
      }
    }
  }
  std::fill_n(F, N * N, 0.0);
  std::fill_n(in0, N * 3, 0.0);
  std::fill_n(in1, N * 3, 0.0);
  F[0] = F[N + 1] = 1.0;
  for (std::size_t i = 0; i < body; ++i) {
    for (std::size_t j = 0; j < columns; ++j) F[i * N + 2 + j] = sum[i][j];
    for (std::size_t c = 0; c < 3; ++c) {
      in0[i * 3 + c] = p1[i][c] - p2[i][c];
      in1[i * 3 + c] = p2[i][c];
    }
  }
  for (std::size_t i = body; i < N; ++i) F[i * (N + 1)] = std::exp(A[i * (N + 1)] * h);
}

void exponentials(std::size_t n, const double* A, double h, double* F, double* in0, double* in1) {
  switch (n) {
    case 9:
      return exponentials<9>(A, h, F, in0, in1);
    case 10:
      return exponentials<10>(A, h, F, in0, in1);
    case 11:
      return exponentials<11>(A, h, F, in0, in1);
    case 12:
      return exponentials<12>(A, h, F, in0, in1);
    default:
      return exponentials<channels + max_memory + noise_states>(A, h, F, in0, in1);
  }
}

/// Cuts the step where the series would not converge well: a stiff lag. Inputs and outputs as exponentials().
void transition(const double* A, std::size_t n, double h, double* F, double* in0, double* in1) {
  double fastest = 0.0;
  for (std::size_t i = 3; i < n; ++i) fastest = std::max(fastest, std::abs(A[i * n + i]));
  const int pieces = std::max(1, static_cast<int>(std::ceil(h * fastest / 2.0)));
  if (pieces == 1) {
    exponentials(n, A, h, F, in0, in1);
    return;
  }
  std::vector<double> f(n * n), a0(n * 3), a1(n * 3), Fs(n * n, 0.0), s0(n * 3, 0.0), s1(n * 3, 0.0), next(n * n);
  exponentials(n, A, h / pieces, f.data(), a0.data(), a1.data());
  for (std::size_t i = 0; i < n; ++i) Fs[i * n + i] = 1.0;
  const auto advance = [&](std::vector<double>& rows, std::size_t columns) {
    std::fill(next.begin(), next.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t l = 0; l < n; ++l)
        for (std::size_t j = 0; j < columns; ++j) next[i * columns + j] += f[i * n + l] * rows[l * columns + j];
    std::copy_n(next.begin(), n * columns, rows.begin());
  };
  for (int p = 0; p < pieces; ++p) {
    advance(Fs, n);
    advance(s0, 3);
    advance(s1, 3);
    const double begin = static_cast<double>(p) / pieces, end = static_cast<double>(p + 1) / pieces;
    for (std::size_t i = 0; i < n * 3; ++i) {
      s0[i] += a0[i] * (1.0 - begin) + a1[i] * (1.0 - end);
      s1[i] += a0[i] * begin + a1[i] * end;
    }
  }
  std::copy(Fs.begin(), Fs.end(), F);
  std::copy(s0.begin(), s0.end(), in0);
  std::copy(s1.begin(), s1.end(), in1);
}

}  // namespace

LinearModel linearise(const StagedCar& car, const Trace& trace, int substeps) {
  const auto m = static_cast<std::size_t>(car.memory());
  if (m > max_memory) throw std::invalid_argument("more than 4 hidden states in one model");
  LinearModel lm;
  lm.n = trace.size();
  lm.dt = trace.log.dt;
  const std::size_t body = channels + m, N = lm.states = body + noise_states;
  lm.memory = run_memory(car, trace);

  // Rates by the state at every sample.
  std::vector<double> A(lm.n * N * N, 0.0);
  const DualPass pass{car, trace, lm.memory};
  pass.run({}, true, [&](std::size_t k, const Dual8* rate, const Dual8* memory_rate) {
    double* const a = A.data() + k * N * N;
    const auto row = [&](std::size_t i, const Dual8& r) {
      for (std::size_t c = 0; c < 4; ++c) a[i * N + 2 + c] = r.d[c];
      for (std::size_t j = 0; j < std::min<std::size_t>(m, 4); ++j) a[i * N + channels + j] = r.d[4 + j];
    };
    for (std::size_t i = 0; i < channels; ++i) row(i, rate[i]);
    for (std::size_t j = 0; j < m; ++j) row(channels + j, memory_rate[j]);
    for (std::size_t c = 0; c < noise_states; ++c) {
      a[(3 + c) * N + body + c] = 1.0;
      a[(body + c) * N + body + c] = -1.0 / noise_time;
    }
  });

  if (!trace.log.guessed.empty())
    for (std::size_t k = 0; k + 1 < lm.n; ++k) lm.guessed.push_back(trace.log.guessed_step(k));
  lm.F.resize((lm.n - 1) * N * N);
  lm.input0.resize((lm.n - 1) * N * 3);
  lm.input1.resize((lm.n - 1) * N * 3);
  std::vector<double> mean(N * N);
  for (std::size_t k = 0; k + 1 < lm.n; ++k) {
    for (std::size_t i = 0; i < N * N; ++i) mean[i] = 0.5 * (A[k * N * N + i] + A[(k + 1) * N * N + i]);
    transition(mean.data(), N, lm.dt, lm.F.data() + k * N * N, lm.input0.data() + k * N * 3,
               lm.input1.data() + k * N * 3);
  }

  // A stiff memory needs shorter steps than the motion.
  double fastest = 0.0;
  for (std::size_t k = 0; k < lm.n; ++k)
    for (std::size_t j = channels; j < body; ++j) fastest = std::max(fastest, std::abs(A[k * N * N + j * N + j]));
  // Where it settles many times within a sample, what settles is small and only must not grow.
  const double settles = std::min(lm.dt * fastest, 20.0);
  substeps = std::max(substeps, static_cast<int>(std::ceil(settles / (settles < 4.0 ? 0.8 : 1.4))));
  step_all(car, trace, lm.memory, substeps, lm.offset);
  for (std::size_t k = 0; k + 1 < lm.n; ++k) {
    double* const f = lm.offset.data() + k * body;
    for (std::size_t c = 0; c < channels; ++c) f[c] -= trace.motion[(k + 1) * channels + c];
    for (std::size_t j = 0; j < m; ++j) f[channels + j] -= lm.memory[(k + 1) * m + j];
  }

  lm.innovation.resize(lm.n * channels);
  bool plain = true;
  std::vector<double> H(lm.n * channels * channels, 0.0);
  read_pass(car, trace, {}, true, [&](std::size_t k, const std::array<Dual8, channels>& out) {
    for (std::size_t c = 0; c < channels; ++c) {
      lm.innovation[k * channels + c] = trace.log.reading[k * channels + c] - out[c].v;
      for (std::size_t j = 0; j < channels; ++j) {
        H[(k * channels + c) * channels + j] = out[c].d[j];
        plain &= out[c].d[j] == (c == j ? 1.0 : 0.0);
      }
    }
  });
  if (!plain) lm.H = std::move(H);
  return lm;
}

int substeps_of_motion(const StagedCar& car, std::span<const Trace> traces) {
  constexpr double longest = 0.3;  // of a step over the time constant: an error of 0.3^5 / 120 of what settles
  std::vector<double> fastest;
  for (const Trace& trace : traces)
    DualPass{car, trace, run_memory(car, trace)}.run({}, true, [&](std::size_t, const Dual8* rate, const Dual8*) {
      double one = 0.0;
      for (std::size_t c = 3; c < channels; ++c) one = std::max(one, std::abs(rate[c].d[c - 2]));
      fastest.push_back(one * trace.log.dt);
    });
  if (fastest.empty()) return 2;
  const auto middle = fastest.begin() + static_cast<std::ptrdiff_t>(fastest.size() / 2);
  std::nth_element(fastest.begin(), middle, fastest.end());
  return static_cast<int>(std::clamp(std::ceil(*middle / longest), 1.0, 8.0));
}

namespace {

/// Where the fitted parameters of member i stand among the car's.
std::vector<std::size_t> slots(const Catalogue& catalogue, const ModelSpec& model, const StagedCar& car,
                               std::size_t member) {
  std::vector<std::size_t> at;
  const std::size_t offset = car.param_offset(static_cast<int>(catalogue.own_effects() + member));
  for (const std::size_t f : catalogue.candidates()[model.members[member]].fitted) at.push_back(offset + f);
  return at;
}

/// Fills directions[first + i] from the car's parameters `seed`, eight at a time.
void exact_directions(const StagedCar& car, const Trace& trace, const std::vector<double>& memory,
                      std::span<const std::size_t> seed, bool readings, std::span<Direction> directions) {
  for (std::size_t begin = 0; begin < seed.size(); begin += 8) {
    const auto part = seed.subspan(begin, std::min<std::size_t>(8, seed.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) directions[begin + i].rate.assign(trace.size() * 3, 0.0);
    DualPass{car, trace, memory}.run(part, false, [&](std::size_t k, const Dual8* rate, const Dual8*) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) directions[begin + i].rate[k * 3 + c] = rate[3 + c].d[i];
    });
    if (!readings) continue;
    for (std::size_t i = 0; i < part.size(); ++i) directions[begin + i].reading.assign(trace.size() * channels, 0.0);
    read_pass(car, trace, part, false, [&](std::size_t k, const std::array<Dual8, channels>& out) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) directions[begin + i].reading[k * channels + c] = out[c].d[i];
    });
  }
}

/// A parameter of an effect that remembers changes its whole past: rates with it moved up minus rates with it moved
/// down, memory run along the reference both times.
Direction difference_direction(StagedCar& car, const Trace& trace, std::size_t slot, double up, double down) {
  const double keep = car.params()[slot];
  const auto rates = [&](double value) {
    car.params()[slot] = value;
    return rates_at_samples(car, trace, run_memory(car, trace));
  };
  const std::vector<double> high = rates(up), low = rates(down);
  car.params()[slot] = keep;
  Direction d;
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      d.rate[k * 3 + c] = (high[k * channels + 3 + c] - low[k * channels + 3 + c]) / (up - down);
  return d;
}

/// Rates hold the memory fixed, but a parameter that acts before an effect with memory also changes what that effect
/// remembers: with relaxing tyres nothing of a tyre shows in the rates at all. Such parameters are moved and the memory
/// is run anew.
bool is_remembered(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate) {
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    return catalogue.candidates()[m].effect->memory() > 0 && catalogue.before(candidate, m);
  });
}
bool nominal_is_remembered(const Catalogue& catalogue, const ModelSpec& model) {
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    const Effect& effect = *catalogue.candidates()[m].effect;
    return effect.memory() > 0 && effect.stage() > Stage::command;
  });
}

/// The same as exact_directions where memories change with the parameters; `step` by parameter, `base` the rates of the
/// car as it is.
void moved_directions(StagedCar& car, const Trace& trace, std::span<const std::size_t> seed,
                      std::span<const double> step, const std::vector<double>& base, std::span<Direction> directions) {
  for (std::size_t i = 0; i < seed.size(); ++i) {
    const double keep = car.params()[seed[i]];
    car.params()[seed[i]] = keep + step[i];
    const std::vector<double> rates = rates_at_samples(car, trace, run_memory(car, trace));
    car.params()[seed[i]] = keep;
    std::vector<double>& rate = directions[i].rate;
    rate.resize(trace.size() * 3);
    for (std::size_t k = 0; k < trace.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        rate[k * 3 + c] = (rates[k * channels + 3 + c] - base[k * channels + 3 + c]) / step[i];
  }
}

constexpr double small_step = 1e-3;  // of a parameter's scale, for differences

}  // namespace

std::vector<Direction> own_directions(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                                      const std::vector<double>& memory) {
  StagedCar car = catalogue.build(model);
  std::vector<std::size_t> seed;
  std::vector<std::size_t> place;
  std::size_t count = 0;
  struct Moved {
    std::size_t slot, place;
    double up, down;
  };
  std::vector<Moved> moved;
  const bool remembered = nominal_is_remembered(catalogue, model);
  for (const Nuisance& n : catalogue.nuisances()) {
    if (remembered) {
      const double value = car.params()[n.index], step = small_step * n.sigma;
      moved.push_back({n.index, count++, value + step, value - step});
      continue;
    }
    seed.push_back(n.index);
    place.push_back(count++);
  }
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[model.members[i]];
    const auto at = slots(catalogue, model, car, i);
    const bool later = is_remembered(catalogue, model, model.members[i]);
    for (std::size_t f = 0; f < at.size(); ++f) {
      if (later && !c.remembers) {
        const double value = car.params()[at[f]], step = small_step * c.decl(f).scale;
        moved.push_back({at[f], count++, value + step, value - step});
        continue;
      }
      if (!c.remembers) {
        seed.push_back(at[f]);
        place.push_back(count++);
        continue;
      }
      // Half a sample for a delay, whose rates have kinks; a per mille of its value for a memory.
      const double value = car.params()[at[f]];
      const double step = c.effect->memory() > 0 ? 1e-3 * std::abs(value) + 1e-6 * c.decl(f).scale : 0.5 * trace.log.dt;
      moved.push_back({at[f], count++, value + step, value - step});
    }
  }
  std::vector<Direction> exact(seed.size()), all(count);
  exact_directions(car, trace, memory, seed, reads(catalogue, model), exact);
  for (std::size_t i = 0; i < seed.size(); ++i) all[place[i]] = std::move(exact[i]);
  for (const Moved& one : moved) all[one.place] = difference_direction(car, trace, one.slot, one.up, one.down);
  return all;
}

namespace {

/// True when nothing at all depends on the direction.
bool vanishes(const Direction& d) {
  const auto zero = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return x == 0.0; });
  };
  return zero(d.rate) && zero(d.reading);
}

/// A model with one more effect at given values.
ModelSpec with_values(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate,
                      const std::vector<double>& values) {
  ModelSpec more = catalogue.with(model, candidate);
  more.values[more.position(candidate)] = values;
  return more;
}

std::vector<double> at_neutral(const Candidate& c) {
  std::vector<double> values = c.defaults;
  for (std::size_t f = 0; f < c.fitted.size(); ++f) values[c.fitted[f]] = c.decl(f).neutral;
  return values;
}

/// Starts for a parameter that shapes an effect but does nothing while the effect is at its neutral value: a scan in
/// steps of its scale, ten to either side of its start.
std::vector<double> scan(const abi::ParamDecl& p) {
  std::vector<double> values;
  for (int i = -10; i < 10; ++i) {
    const double value = p.start + i * p.scale;
    if (value >= p.lo && value <= p.hi) values.push_back(value);
  }
  return values;
}

}  // namespace

void candidate_directions(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                          const std::vector<double>& memory, const std::vector<double>& base_rates,
                          std::vector<Direction>& directions, std::vector<Group>& groups) {
  for (std::size_t i = 0; i < catalogue.candidates().size(); ++i) {
    const Candidate& c = catalogue.candidates()[i];
    if (c.excluded || model.has(i)) continue;
    if (static_cast<int>(memory.size() / std::max<std::size_t>(1, trace.size())) + c.effect->memory() > 4) continue;
    Group group;
    group.candidate = i;
    group.first = directions.size();
    if (c.remembers) {
      // A secant from the model without the effect to the effect at its start.
      const ModelSpec more = catalogue.with(model, i);
      StagedCar car = catalogue.build(more);
      const std::vector<double> rates = rates_at_samples(car, trace, run_memory(car, trace));
      Direction d;
      d.rate.resize(trace.size() * 3);
      const double unit = c.decl(0).start - c.decl(0).neutral;
      for (std::size_t k = 0; k < trace.size(); ++k)
        for (std::size_t r = 0; r < 3; ++r)
          d.rate[k * 3 + r] = (rates[k * channels + 3 + r] - base_rates[k * channels + 3 + r]) / unit;
      directions.push_back(std::move(d));
      group.units.push_back(1.0);
    } else {
      ModelSpec more = with_values(catalogue, model, i, at_neutral(c));
      StagedCar car = catalogue.build(more);
      const auto at = slots(catalogue, more, car, more.position(i));
      std::vector<Direction> all(at.size());
      const bool later = is_remembered(catalogue, model, i);
      std::vector<double> step;
      for (std::size_t f = 0; f < at.size(); ++f) step.push_back(small_step * c.decl(f).scale);
      if (later)
        moved_directions(car, trace, at, step, base_rates, all);
      else
        exact_directions(car, trace, memory, at, c.effect->stage() == Stage::reading, all);
      std::vector<std::size_t> shapes;
      for (std::size_t f = 0; f < all.size(); ++f)
        if (vanishes(all[f])) shapes.push_back(f);
      if (shapes.empty() || shapes.size() == all.size()) {
        for (Direction& d : all) {
          directions.push_back(std::move(d));
          group.units.push_back(1.0);
        }
      } else {
        // Scan the first shape parameter; the strength is the first parameter that does something.
        std::size_t strength = 0;
        while (vanishes(all[strength])) ++strength;
        for (const double value : scan(c.decl(shapes.front()))) {
          car.params()[at[shapes.front()]] = value;
          for (std::size_t f = 1; f < shapes.size(); ++f) car.params()[at[shapes[f]]] = c.decl(shapes[f]).start;
          std::vector<Direction> one(1);
          const std::size_t seed[] = {at[strength]};
          if (later)
            moved_directions(car, trace, seed, std::span(step).subspan(strength, 1), base_rates, one);
          else
            exact_directions(car, trace, memory, seed, false, one);
          directions.push_back(std::move(one.front()));
          group.units.push_back(1.0);
          std::vector<double> start = c.defaults;
          start[c.fitted[shapes.front()]] = value;
          group.starts.push_back(std::move(start));
        }
      }
    }
    group.count = directions.size() - group.first;
    groups.push_back(std::move(group));
  }
}

}  // namespace gripline::diagnose
