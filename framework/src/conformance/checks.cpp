#include "conformance/checks.hpp"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>
#include <thread>

#include "config/units.hpp"
#include "conformance/exercise.hpp"
#include "conformance/formula.hpp"
#include "util/child_process.hpp"
#include "util/clock.hpp"
#include "util/numbers.hpp"

namespace gripline::conformance {
namespace {

constexpr double patience_s = 60;  // for one answer
constexpr std::string_view broken_mark = "broken ";

constexpr unsigned bit(abi::Kind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned formulas = bit(abi::Kind::vehicle) | bit(abi::Kind::effect) | bit(abi::Kind::estimator);
constexpr unsigned every_kind = (1u << abi::kind_count) - 1;

using Tell = SendMessage;

/// Asks a process of its own that has opened the library; what it answered. Throws Broken when it broke a contract or
/// did not come back.
std::vector<std::string> ask(const Workshop& workshop, const std::function<void(const Registry&, const Tell&)>& work) {
  const ChildResult result = run_in_child(patience_s, [&](const Tell& tell) {
    try {
      const Registry registry({workshop.folder});
      for (const Registry::Unusable& one : registry.unusable()) throw Broken(one.reason);
      work(registry, tell);
    } catch (const Broken& broken) {
      tell(std::string(broken_mark) + broken.what());
    }
  });
  if (!result.messages.empty() && result.messages.back().starts_with(broken_mark))
    throw Broken(result.messages.back().substr(broken_mark.size()));
  if (!result.completed) {
    const std::string place = result.messages.empty() ? "" : " (" + result.messages.back() + ")";
    throw Broken((result.failure.starts_with("threw") ? "" : "its process ") + result.failure + place);
  }
  return result.messages;
}

/// ask() with the plugin's entry and the bench to make an instance in.
std::vector<std::string> ask_instance(const Workshop& workshop, const Subject& subject,
                                      const std::function<void(const PluginEntry&, Bench&, const Tell&)>& work) {
  return ask(workshop, [&](const Registry& registry, const Tell& tell) {
    Bench bench(workshop.cache.string());
    work(registry.find(subject.kind, subject.id), bench, tell);
  });
}

std::unique_ptr<Exercise> nominal_exercise(const PluginEntry& entry, Bench& bench) {
  return make_exercise(entry, bench, bench.context(entry), nominal_values(entry));
}

void require_finite(const std::vector<double>& answers, const std::string& where) {
  for (const double answer : answers)
    if (!std::isfinite(answer)) throw Broken("an answer " + where + " is " + significant(answer, 4));
}

std::string fingerprint(const std::vector<double>& answers) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const double answer : answers) {
    unsigned char bytes[sizeof answer];
    std::memcpy(bytes, &answer, sizeof answer);
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211u;
  }
  return std::to_string(answers.size()) + " numbers " + std::to_string(hash);
}

// ---- the checks ----

void check_param(const abi::ParamDecl& p, std::set<std::string>& names) {
  const std::string name = p.name;
  if (name.empty()) throw Broken("a parameter has no name");
  if (!names.insert(name).second) throw Broken("two parameters are called " + name);
  if (*p.doc == '\0') throw Broken(name + " has no sentence that says what it is");
  try {
    (void)Unit::parse(p.unit);
  } catch (const UnitError& error) {
    throw Broken("the unit of " + name + ": " + error.what());
  }
  if (p.type == abi::ParamType::table) return;
  if (p.type != abi::ParamType::choice && p.type != abi::ParamType::boolean) {
    if (!(p.lo < p.hi))
      throw Broken(name + " has no range: [" + significant(p.lo, 4) + ", " + significant(p.hi, 4) + "]");
    if (!(p.default_value >= p.lo && p.default_value <= p.hi))
      throw Broken("the default of " + name + ", " + significant(p.default_value, 4) + ", is outside its range");
  }
  if (p.fit && !(p.start >= p.lo && p.start <= p.hi))
    throw Broken("a fit of " + name + " would start at " + significant(p.start, 4) + ", outside its range");
  if (p.fit && !(p.scale > 0))
    throw Broken("the scale of " + name + " is to be above 0, it is " + significant(p.scale, 4));
}

std::string check_manifest(const Workshop& workshop, const Subject& subject) {
  ask(workshop, [&](const Registry& registry, const Tell&) {
    const PluginEntry& entry = registry.find(subject.kind, subject.id);
    const abi::PluginDecl& decl = *entry.decl;
    for (const char c : subject.id)
      if (std::strchr("abcdefghijklmnopqrstuvwxyz0123456789_.-", c) == nullptr)
        throw Broken("an id is made of a-z, 0-9, '_', '.' and '-': \"" + subject.id + "\"");
    if (*decl.version == '\0') throw Broken("it has no version");
    if (*decl.summary == '\0') throw Broken("it has no sentence that says what it is");
    if (std::strchr(decl.summary, '\n') != nullptr) throw Broken("its summary has more than one line");
    const bool may_have_truth =
        (bit(decl.kind) & (bit(abi::Kind::estimator) | bit(abi::Kind::planner) | bit(abi::Kind::controller))) != 0;
    if (entry.needs_truth() && !may_have_truth)
      throw Broken("needs_truth() is for estimators, planners and controllers; no " +
                   std::string(kind_name(decl.kind)) + " is given the ground truth");
    std::set<std::string> names;
    for (const abi::ParamDecl& p : entry.params()) check_param(p, names);
  });
  return {};
}

/// Every number at both ends of its range: made, or refused in words.
std::string check_parameters(const Workshop& workshop, const Subject& subject) {
  const std::vector<std::string> answers =
      ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell& tell) {
        constexpr double enough_s = 2;
#if !defined(__SANITIZE_ADDRESS__)                 // which reserves terabytes
        constexpr rlim_t room = rlim_t{4} << 30U;  // what wants more gets std::bad_alloc, which is a refusal in words
        const rlimit limit{room, room};
        setrlimit(RLIMIT_AS, &limit);
#endif
        tell("with the defaults");
        nominal_exercise(entry, bench);
        int asked = 0, all = 0;
        for (std::size_t i = 0; i < entry.params().size(); ++i) {
          const abi::ParamDecl& p = entry.params()[i];
          if (p.type == abi::ParamType::table || p.type == abi::ParamType::choice) continue;
          const bool boolean = p.type == abi::ParamType::boolean;
          for (const double end : {boolean ? 0.0 : p.lo, boolean ? 1.0 : p.hi}) {
            ++all;
            if (thread_cpu_s() > enough_s) continue;
            ++asked;
            tell(std::string("with ") + p.name + " = " + significant(end, 4));
            std::vector<abi::ParamValue> values = nominal_values(entry);
            values[i].number = end;
            try {
              make_exercise(entry, bench, bench.context(entry), values)->step(0, nullptr);
            } catch (const std::exception& refused) {
              if (*refused.what() == '\0')
                throw Broken(std::string("refuses ") + p.name + " = " + significant(end, 4) + " without a message");
            }
          }
        }
        tell(asked == all ? "" : std::to_string(asked) + " of " + std::to_string(all) + " ends in the time allowed");
      });
  return answers.back();
}

/// 400 samples of the drive, or those that take a second and a half of CPU: a correction worth checking.
void teach(Estimator& estimator, Bench& bench) {
  constexpr double enough_s = 1.5;
  const double begin = thread_cpu_s();
  for (std::int64_t k = 0; k < 400 && thread_cpu_s() - begin < enough_s; ++k) estimator.update(bench.sample(k));
}

std::string check_derivatives(const Workshop& workshop, const Subject& subject) {
  ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell&) {
    const std::vector<abi::ParamValue> values = nominal_values(entry);
    const PluginContext context = bench.context(entry);
    const auto require_exact = [&](const void* instance) {
      if (const std::string problem = derivative_problem(*formula_of(entry.decl->kind, instance, entry, values));
          !problem.empty())
        throw Broken(problem);
    };
    if (entry.decl->kind == abi::Kind::vehicle) {
      require_exact(create<VehicleModel>(entry, context, values).get());
    } else if (entry.decl->kind == abi::Kind::effect) {
      require_exact(create<Effect>(entry, context, values).get());
    } else {
      const Instance<Estimator> estimator = create<Estimator>(entry, context, values);
      teach(*estimator, bench);
      require_exact(estimator.get());
    }
  });
  return {};
}

std::string check_finite(const Workshop& workshop, const Subject& subject) {
  ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell&) {
    const auto exercise = nominal_exercise(entry, bench);
    std::vector<double> answers;
    for (std::int64_t k = 0; k < 20; ++k) exercise->step(k, &answers);
    require_finite(answers, "on an ordinary step");
    const char* where = "";
    try {
      exercise->extremes(where, &answers);
    } catch (const std::exception& thrown) {
      throw Broken(std::string(where) + ": threw " + thrown.what());
    }
    require_finite(answers, "at the edges (standstill, reverse, full lock, off the road)");
  });
  return {};
}

std::string check_batch(const Workshop& workshop, const Subject& subject) {
  ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell&) {
    const std::vector<abi::ParamValue> values = nominal_values(entry);
    const auto require_same = [&](const void* instance) {
      if (const std::string problem = batch_problem(*formula_of(entry.decl->kind, instance, entry, values));
          !problem.empty())
        throw Broken(problem);
    };
    const PluginContext context = bench.context(entry);
    if (entry.decl->kind == abi::Kind::vehicle)
      require_same(create<VehicleModel>(entry, context, values).get());
    else if (entry.decl->kind == abi::Kind::effect)
      require_same(create<Effect>(entry, context, values).get());
    else {
      const Instance<Estimator> estimator = create<Estimator>(entry, context, values);
      teach(*estimator, bench);
      require_same(estimator.get());
    }
  });
  return {};
}

/// How many steps are asked for: 300, or what takes a second of CPU.
std::int64_t affordable_steps(const Workshop& workshop, const Subject& subject) {
  const std::string spent =
      ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell& tell) {
        constexpr std::int64_t steps = 20;
        const auto exercise = nominal_exercise(entry, bench);
        const double begin = thread_cpu_s();
        for (std::int64_t k = 0; k < steps; ++k) exercise->step(k, nullptr);
        tell(significant((thread_cpu_s() - begin) / steps, 4));
      }).back();
  return static_cast<std::int64_t>(std::clamp(1.0 / (std::stod(spent) + 1e-6), 20.0, 300.0));
}

/// What an instance answers in the first steps, alone in its process.
std::string trace(const Workshop& workshop, const Subject& subject, std::int64_t steps) {
  return ask_instance(workshop, subject,
                      [&](const PluginEntry& entry, Bench& bench, const Tell& tell) {
                        const auto exercise = nominal_exercise(entry, bench);
                        std::vector<double> answers;
                        for (std::int64_t k = 0; k < steps; ++k) exercise->step(k, &answers);
                        tell(fingerprint(answers));
                      })
      .back();
}

std::string check_deterministic(const Workshop& workshop, const Subject& subject) {
  const std::int64_t steps = affordable_steps(workshop, subject);
  if (trace(workshop, subject, steps) != trace(workshop, subject, steps))
    throw Broken("two runs from the same seed answer differently; all randomness is to come from context.seed");
  return {};
}

std::string check_isolated(const Workshop& workshop, const Subject& subject) {
  const std::int64_t steps = affordable_steps(workshop, subject);
  const std::string alone = trace(workshop, subject, steps);
  const std::string beside =
      ask_instance(workshop, subject, [&](const PluginEntry& entry, Bench& bench, const Tell& tell) {
        const auto other = nominal_exercise(entry, bench);
        for (std::int64_t k = 0; k < steps / 8; ++k) other->step(k + 77, nullptr);
        const auto exercise = nominal_exercise(entry, bench);
        std::vector<double> answers;
        for (std::int64_t k = 0; k < steps; ++k) {
          if (k < steps / 3) other->step(k + 117, nullptr);
          exercise->step(k, &answers);
        }
        tell(fingerprint(answers));
      }).back();
  if (alone != beside)
    throw Broken("an instance answers differently when another one works beside it: no static or global state");
  return {};
}

/// Const calls from four threads at once give what they give from one.
std::string check_threads(const Workshop& workshop, const Subject& subject) {
  ask_instance(workshop, subject, [](const PluginEntry& entry, Bench& bench, const Tell&) {
    const auto exercise = nominal_exercise(entry, bench);
    for (std::int64_t k = 0; k < 30; ++k) exercise->step(k, nullptr);
    std::vector<double> serial;
    exercise->ask(&serial);
    const double begin = process_cpu_s();
    std::array<bool, 4> same{};
    std::array<std::thread, 4> threads;
    for (std::size_t i = 0; i < threads.size(); ++i)
      threads[i] = std::thread([&, i] {
        std::vector<double> answers;
        same[i] = true;
        for (int k = 0; k < 3000 && process_cpu_s() - begin < 2; ++k) {
          answers.clear();
          static_cast<const Exercise&>(*exercise).ask(&answers);
          same[i] = same[i] && answers.size() == serial.size() &&
                    std::memcmp(answers.data(), serial.data(), serial.size() * sizeof(double)) == 0;
        }
      });
    for (std::thread& thread : threads) thread.join();
    for (const bool one : same)
      if (!one)
        throw Broken("const calls from four threads answer differently than from one: no scratch in the instance");
  });
  return {};
}

std::string check_truth(const Workshop& workshop, const Subject& subject) {
  const auto run = [&](bool always_truth) {
    ask_instance(workshop, subject, [&](const PluginEntry& entry, Bench& bench, const Tell&) {
      const auto exercise = make_exercise(entry, bench, bench.context(entry, always_truth), nominal_values(entry));
      for (std::int64_t k = 0; k < 30; ++k) exercise->step(k, nullptr);
    });
  };
  if (subject.needs_truth) {
    run(false);
    return "is given the ground truth: its rows are marked *";
  }
  try {
    run(false);
  } catch (const Broken& broken) {
    bool works_when_told = true;
    try {
      run(true);
    } catch (const Broken&) {
      works_when_told = false;
    }
    if (!works_when_told) throw;
    throw Broken("uses context.truth, which is null without .needs_truth() behind describe: " +
                 std::string(broken.what()));
  }
  return {};
}

std::string check_allocation(const Workshop& workshop, const Subject& subject) {
  if (workshop.allocations == nullptr) return "not counted here";
  ask_instance(workshop, subject, [&](const PluginEntry& entry, Bench& bench, const Tell&) {
    const auto exercise = nominal_exercise(entry, bench);
    constexpr double enough_s = 1;
    std::int64_t k = 0, counted = 0;
    for (const double begin = thread_cpu_s(); k < 150 && thread_cpu_s() - begin < enough_s; ++k)
      exercise->step(k, nullptr);
    const std::int64_t before = workshop.allocations();
    for (const double begin = thread_cpu_s(); counted < 200 && thread_cpu_s() - begin < enough_s; ++counted)
      exercise->step(k + counted, nullptr);
    const double each = static_cast<double>(workshop.allocations() - before) / static_cast<double>(counted);
    if (each > 0) throw Broken(significant(each, 4) + " allocations a step");
  });
  return {};
}

std::string check_learns(const Workshop& workshop, const Subject& subject) {
  return ask_instance(
             workshop, subject,
             [](const PluginEntry& entry, Bench& bench, const Tell& tell) {
               const Learned learned = learn(entry, bench, nominal_values(entry));
               constexpr std::array names = {"vx", "vy", "omega"};
               bool nothing = true;
               std::string words;
               for (std::size_t c = 0; c < 3; ++c) {
                 const double left = learned.left[c];
                 if (!(left <= 1.05) && !learned.cut_short)
                   throw Broken(std::string("after a drive at the limit its correction makes the prediction of ") +
                                names[c] + " worse: the residual is " + significant(100 * left, 4) +
                                " % of the nominal model's");
                 nothing = nothing && left == 1.0;
                 words += (c > 0 ? ", " : "") + significant(std::round(100 * left), 4) + " %";
               }
               const Belief& b = learned.belief;
               for (const double mu : {b.mu_front, b.mu_rear})
                 if (!(mu > 0.01 && mu < 10)) throw Broken("estimates a friction of " + significant(mu, 4));
               const std::string left =
                   nothing ? "does not change the model" : words + " of the residuals of vx, vy, omega are left";
               tell((learned.cut_short ? "trained on a part of the drive only, not judged: " : "") + left);
             })
      .back();
}

std::string check_bounds(const Workshop& workshop, const Subject& subject) {
  return ask_instance(
             workshop, subject,
             [](const PluginEntry& entry, Bench& bench, const Tell& tell) {
               const Lap lap = drive_lap(entry, bench, nominal_values(entry));
               constexpr double slack = 1e-6;
               if (lap.largest_d > slack)
                 throw Broken("asks for throttle beyond the car's limits by " + significant(lap.largest_d, 4));
               if (lap.largest_ddelta > slack)
                 throw Broken("asks for a steering rate beyond the car's limit by " +
                              significant(lap.largest_ddelta, 4) + " rad/s");
               if (lap.largest_delta > slack)
                 throw Broken("asks for steering beyond the car's limit by " + significant(lap.largest_delta, 4) +
                              " rad");
               if (10 * lap.unsolved > lap.steps)
                 throw Broken(std::to_string(lap.unsolved) + " of " + std::to_string(lap.steps) + " solves failed");
               if (lap.farthest > 0.3)
                 throw Broken("leaves a road of 0.3 m to either side at 0.8 m/s: " + significant(lap.farthest, 4) +
                              " m off the line");
               if (!lap.cut_short && lap.covered < lap.length)
                 throw Broken("does not get around 9 m in 24 s: " + significant(lap.covered, 4) + " m");
               tell((lap.cut_short ? "a part of a lap in " : "a lap in ") +
                    significant(static_cast<double>(lap.steps) * dt, 4) + " s, " + significant(100 * lap.farthest, 4) +
                    " cm off the line at most");
             })
      .back();
}

std::string check_growth(const Workshop& workshop, const Subject& subject) {
  return ask_instance(workshop, subject,
                      [](const PluginEntry& entry, Bench& bench, const Tell& tell) {
                        const auto held = [] {
                          const auto info = mallinfo2();
                          return static_cast<double>(info.uordblks + info.hblkhd);
                        };
                        constexpr std::int64_t steps = 100'000;
                        constexpr double enough_s = 2;
                        const auto exercise = nominal_exercise(entry, bench);
                        const double begin = thread_cpu_s();
                        std::int64_t k = 0, warm = 0;
                        double before = held();
                        for (; k < steps && thread_cpu_s() - begin < enough_s; ++k) {
                          exercise->step(k, nullptr);
                          if (k == 2000 || (warm == 0 && thread_cpu_s() - begin > 0.3 * enough_s))
                            warm = k, before = held();
                        }
                        const double grown = held() - before,
                                     each = grown / static_cast<double>(std::max<std::int64_t>(1, k - warm));
                        if (grown > 4096 && each > 0.5)
                          throw Broken("holds " + significant(grown / 1024, 4) + " KiB more after " +
                                       std::to_string(k) + " steps, " + significant(each, 4) + " bytes a step");
                        tell(std::to_string(k) + " steps");
                      })
      .back();
}

constexpr std::array all_checks = {
    Check{"manifest", "id, version and summary; parameters with sentence, unit, range", every_kind, check_manifest},
    Check{"parameters", "made, or refused with a message, at both ends of every range", every_kind, check_parameters},
    Check{"truth", "works without the truth, unless it declares needs_truth", every_kind, check_truth},
    Check{"finite", "finite at standstill, in reverse, at full lock, off the road", every_kind, check_finite},
    Check{"derivatives", "derivatives agree with differences, Dual8 with double", formulas, check_derivatives},
    Check{"batch", "many points in one call are each as alone", formulas, check_batch},
    Check{"deterministic", "the same seed gives the same answers", every_kind, check_deterministic},
    Check{"isolated", "instances do not touch each other", every_kind, check_isolated},
    Check{"threads", "const calls from four threads answer as from one", every_kind, check_threads},
    Check{"allocation", "a step does not allocate", every_kind, check_allocation},
    Check{"learns", "its correction does not make a drive's residuals larger", bit(abi::Kind::estimator), check_learns},
    Check{"bounds", "stays within the car's limits, and on an easy road", bit(abi::Kind::controller), check_bounds},
    Check{"growth", "memory does not grow over 100,000 steps, or 2 s of them", every_kind, check_growth}};

}  // namespace

std::span<const Check> checks() { return all_checks; }

std::vector<Subject> subjects_in(const Workshop& workshop) {
  std::vector<Subject> subjects;
  for (const std::string& line : ask(workshop, [](const Registry&registry, const Tell&tell) {
         for (const PluginEntry& entry : registry.entries())
           tell(std::to_string(static_cast<int>(entry.decl->kind)) + (entry.needs_truth() ? " t " : " - ") +
                entry.decl->id);
       }))
    subjects.push_back({static_cast<abi::Kind>(line[0] - '0'), line.substr(4), line[2] == 't'});
  if (subjects.empty()) throw Broken("offers no plugin");
  return subjects;
}

double opening_time(const Workshop& workshop) {
  const ChildResult result = run_in_child(patience_s, [&](const Tell& tell) {
    const double begin = thread_cpu_s();
    const Registry registry({workshop.folder});
    tell(significant(thread_cpu_s() - begin, 4));
  });
  if (!result.completed) throw Broken("its process " + result.failure + " when the library was opened");
  return std::stod(result.messages.back());
}

}  // namespace gripline::conformance
