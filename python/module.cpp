// gripline._gripline: what the Python package (python/gripline) needs of the program: its commands in this process,
// races step by step, and Python classes as plugins.
#include <pybind11/iostream.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <pthread.h>

#include <algorithm>
#include <array>
#include <boost/program_options/errors.hpp>
#include <cmath>
#include <deque>
#include <iostream>
#include <memory>
#include <mutex>
#include <new>
#include <numbers>
#include <optional>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include <gripline/plugin.hpp>

#include "config/errors.hpp"
#include "config/shipped.hpp"
#include "experiment/experiment.hpp"
#include "experiment/perturb.hpp"
#include "gripline/command.hpp"
#include "gripline/import_bag.hpp"
#include "gripline/race_kind.hpp"
#include "plugin/guard.hpp"
#include "plugin/offered.hpp"
#include "race/assembly.hpp"
#include "util/signals.hpp"
#include "world/world.hpp"

namespace py = pybind11;

namespace gripline::python {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

Array array_of(std::initializer_list<double> numbers) {
  Array out(static_cast<py::ssize_t>(numbers.size()));
  std::copy(numbers.begin(), numbers.end(), out.mutable_data());
  return out;
}
Array array_of(const State& x) { return array_of({x.x, x.y, x.yaw, x.vx, x.vy, x.omega, x.delta}); }

// ---- threads ----

// The host is made for one thread: of those that call this module the others wait. Threads that stay in Python go on
// during a command, which has released the interpreter's lock and takes it where it prints and asks Python classes.
// Commands race in forks of this process: a fork holds the lock and is a process in which Python can go on.
std::mutex one_call;
thread_local int calls = 0;                      // of this thread, each within the one before
thread_local PyThreadState* released = nullptr;  // this thread's, while a command is without the lock
thread_local bool taken_for_fork = false;
thread_local PyObject* random_numbers = nullptr;  // the state of Python's own generator at a fork

/// Takes all that the program says, in this process alone, and keeps none of it.
class Silence {
 public:
  Silence() : out_(std::cout.rdbuf(&nowhere_)), err_(std::cerr.rdbuf(&nowhere_)), before_(std::exchange(now_, this)) {}
  ~Silence() {
    now_ = before_;
    restore();
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  /// In a fork: what plugins say there belongs into the log of their run. Of several, each within the one before, the
  /// first knows where that is.
  static void end_in_child() {
    for (const Silence* one = now_; one != nullptr; one = one->before_) one->restore();
    now_ = nullptr;
  }

 private:
  struct Nowhere final : std::streambuf {
    int_type overflow(int_type c) override { return traits_type::not_eof(c); }
    std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
  };
  void restore() const {
    std::cout.rdbuf(out_);
    std::cerr.rdbuf(err_);
  }
  static inline Silence* now_ = nullptr;

  Nowhere nowhere_;
  std::streambuf *out_, *err_;
  Silence* before_;
};

void end_dropped_races();

/// The calling thread's turn. Constructed and destroyed with the interpreter's lock.
class Turn {
 public:
  Turn() {
    if (calls == 0 && !one_call.try_lock()) {
      const py::gil_scoped_release others_go_on;
      one_call.lock();
    }
    ++calls;
  }
  /// Of a thread that has locked `one_call`, or is within a call.
  explicit Turn(std::adopt_lock_t) { ++calls; }
  ~Turn() {
    if (calls == 1) end_dropped_races();
    if (--calls == 0) one_call.unlock();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
};

/// Without the interpreter's lock for as long as it lives.
class WithoutPython {
 public:
  WithoutPython() : outer_(released) { released = PyEval_SaveThread(); }
  ~WithoutPython() { PyEval_RestoreThread(std::exchange(released, outer_)); }
  WithoutPython(const WithoutPython&) = delete;
  WithoutPython& operator=(const WithoutPython&) = delete;

 private:
  PyThreadState* outer_;
};

/// Calls a function of the module `random` where a program uses that: what it gives, or null.
PyObject* ask_random(const char* function, PyObject* argument) {
  PyObject* const random = PyDict_GetItemString(PyImport_GetModuleDict(), "random");  // borrowed
  PyObject* const given = random == nullptr     ? nullptr
                          : argument == nullptr ? PyObject_CallMethod(random, function, nullptr)
                                                : PyObject_CallMethod(random, function, "(O)", argument);
  if (given == nullptr) PyErr_Clear();
  return given;
}

// Handlers of pthread_atfork. A fork that Python itself makes (os.fork) holds the lock and has its own.
void before_fork() {
  taken_for_fork = released != nullptr && PyGILState_Check() == 0;
  if (!taken_for_fork) return;
  PyEval_RestoreThread(released);
  random_numbers = ask_random("getstate", nullptr);
  PyOS_BeforeFork();
}
void after_fork_here() {
  if (!std::exchange(taken_for_fork, false)) return;
  PyOS_AfterFork_Parent();
  Py_CLEAR(random_numbers);
  released = PyEval_SaveThread();
}
/// The child keeps the lock: its only thread is this one. Python seeds `random` anew there; runs go on with the numbers
/// of the process that started them, as with those of NumPy.
void after_fork_in_child() {
  if (calls == 0) new (&one_call) std::mutex;  // another thread, which is not here, may have had the turn
  Silence::end_in_child();
  if (!std::exchange(taken_for_fork, false)) return;
  released = nullptr;
  PyOS_AfterFork_Child();
  if (random_numbers != nullptr) Py_XDECREF(ask_random("setstate", random_numbers));
  Py_CLEAR(random_numbers);
}

// ---- Python classes as plugins ----

/// A class that was offered, and the declaration that the registry shows of it.
struct Offered {
  std::string id, version, doc, source;
  std::vector<std::string> texts;  // of the parameters: name, unit, sentence each
  std::vector<abi::ParamDecl> params;
  abi::PluginDecl decl{};
  py::object type;
};
// Never destroyed: instances may outlive the interpreter's end.
std::deque<Offered>& offered() {
  static auto* const all = new std::deque<Offered>;
  return *all;
}

/// What a class threw, in one line: the package words it.
std::string words_of(const py::error_already_set& thrown) {
  const py::object trace = thrown.trace() ? thrown.trace() : py::none();
  return py::module_::import("gripline.plugins").attr("told")(thrown.value(), trace).cast<std::string>();
}
/// Asks a class, with the interpreter's lock; what it throws is a std::runtime_error with its words.
template <class... Given>
py::object ask_class(const py::object& method, const Given&... given) {
  try {
    return method(given...);
  } catch (const py::error_already_set& thrown) {
    throw std::runtime_error(words_of(thrown));
  }
}

py::object make_instance(const Offered& plugin, const PluginContext& context, const abi::ParamValue* values) {
  py::dict car, given, params;
  const Car& c = context.car;
  for (const auto& [name, value] : {std::pair{"m", c.m},
                                    {"Iz", c.Iz},
                                    {"lf", c.lf},
                                    {"lr", c.lr},
                                    {"length", c.length},
                                    {"width", c.width},
                                    {"d_min", c.d_min},
                                    {"d_max", c.d_max},
                                    {"delta_max", c.delta_max},
                                    {"ddelta_max", c.ddelta_max},
                                    {"v_ref", c.v_ref},
                                    {"v_min", c.v_min}})
    car[name] = value;
  given["car"] = car;
  given["dt"] = context.dt;
  given["seed"] = context.seed;
  given["mu_init"] = context.mu_init;
  for (std::size_t i = 0; i < plugin.params.size(); ++i) params[plugin.params[i].name] = values[i].number;
  return plugin.type(given, **params);
}

/// What a class printed goes to its run's log.txt before the process ends.
struct Flush {
  ~Flush() {
    try {
      for (const char* stream : {"stdout", "stderr"}) py::module_::import("sys").attr(stream).attr("flush")();
    } catch (const std::exception&) {
    }
  }
};

class PythonEstimator final : public Estimator {
 public:
  PythonEstimator(const Offered& plugin, const PluginContext& context, const abi::ParamValue* values)
      : instance_(make_instance(plugin, context, values)),
        update_(instance_.attr("update")),
        belief_(instance_.attr("belief")),
        correction_(instance_.attr("correction")) {}

  void update(const Sample& k) override {
    const py::gil_scoped_acquire lock;
    py::dict sample;
    sample["t"] = k.t;
    sample["dt"] = k.dt;
    sample["x"] = array_of(k.x);
    sample["x_next"] = array_of(k.x_next);
    sample["u"] = array_of({k.u.d, k.u.ddelta});
    sample["e"] = array_of({k.e_vx, k.e_vy, k.e_omega});
    sample["kappa"] = k.at.kappa;
    sample["grade"] = k.at.grade;
    sample["bank"] = k.at.bank;
    ask_class(update_, sample);
  }
  Belief belief() const override {
    const py::gil_scoped_acquire lock;
    const auto [front, rear] = ask_class(belief_).cast<std::pair<double, double>>();
    return {front, rear, 0, 0, false};
  }
  void apply(const Points<double>& points) const override {
    if (points.n == 0) return;
    const py::gil_scoped_acquire lock;
    Array rows = make_rows(points.n);
    for (std::size_t i = 0; i < points.n; ++i) fill(rows.mutable_data() + i * inputs, points.q[i]);
    const Array out = ask(rows);
    for (std::size_t i = 0; i < points.n; ++i) {
      points.q[i].ax += out.data()[3 * i];
      points.q[i].ay += out.data()[3 * i + 1];
      points.q[i].aw += out.data()[3 * i + 2];
    }
  }
  /// Derivatives by central differences: all points, moved both ways along every input, in one call.
  void apply(const Points<Dual8>& points) const override {
    if (points.n == 0) return;
    const py::gil_scoped_acquire lock;
    Array rows = make_rows(points.n * (1 + 2 * inputs));
    double* row = rows.mutable_data();
    for (std::size_t i = 0; i < points.n; ++i) {
      fill(row, points.q[i]);
      const double* const centre = row;
      for (std::size_t j = 0; j < inputs; ++j)
        for (const double side : {1.0, -1.0}) {
          row += inputs;
          std::copy_n(centre, inputs, row);
          row[j] += side * step;
        }
      row += inputs;
    }
    const Array out = ask(rows);
    const double* found = out.data();
    for (std::size_t i = 0; i < points.n; ++i, found += 3 * (1 + 2 * inputs)) {
      Quantities<Dual8>& q = points.q[i];
      const std::array<Dual8, inputs> in = {q.vx, q.vy, q.omega, q.d, q.delta};
      Dual8* const into[] = {&q.ax, &q.ay, &q.aw};
      for (std::size_t c = 0; c < 3; ++c) {
        Dual8 change(found[c]);
        for (std::size_t j = 0; j < inputs; ++j) {
          const double slope = (found[3 * (1 + 2 * j) + c] - found[3 * (2 + 2 * j) + c]) / (2 * step);
          for (int k = 0; k < 8; ++k) change.d[k] += slope * in[j].d[k];
        }
        *into[c] += change;
      }
    }
  }

 private:
  static constexpr std::size_t inputs = 5;
  static constexpr double step = 1e-5;
  static Array make_rows(std::size_t n) {
    return Array({static_cast<py::ssize_t>(n), static_cast<py::ssize_t>(inputs)});
  }
  template <class T>
  static void fill(double* row, const Quantities<T>& q) {
    row[0] = value(q.vx), row[1] = value(q.vy), row[2] = value(q.omega), row[3] = value(q.d), row[4] = value(q.delta);
  }
  Array ask(const Array& rows) const {
    Array out = ask_class(correction_, rows).cast<Array>();
    if (out.ndim() != 2 || out.shape(0) != rows.shape(0) || out.shape(1) != 3)
      throw std::runtime_error("correction() is to return (" + std::to_string(rows.shape(0)) + ", 3) numbers");
    return out;
  }
  Flush flush_;
  py::object instance_, update_, belief_, correction_;
};

class PythonController final : public Controller {
 public:
  PythonController(const Offered& plugin, const PluginContext& context, const abi::ParamValue* values)
      : instance_(make_instance(plugin, context, values)),
        control_(instance_.attr("control")),
        horizon_(instance_.attr("horizon").cast<int>()) {}
  int horizon() const noexcept override { return horizon_; }
  Command control(const Observation& now, std::span<const RefPoint> horizon, Prediction&) override {
    const py::gil_scoped_acquire lock;
    py::dict seen;
    seen["t"] = now.t;
    seen["x"] = array_of(now.x);
    seen["d"] = now.d;
    seen["s"] = now.at.s;
    seen["n"] = now.at.n;
    Array reference({static_cast<py::ssize_t>(horizon.size()), py::ssize_t{5}});
    double* row = reference.mutable_data();
    for (const RefPoint& r : horizon) {
      row[0] = r.x, row[1] = r.y, row[2] = r.yaw, row[3] = r.kappa, row[4] = r.v;
      row += 5;
    }
    const auto [d, ddelta] = ask_class(control_, seen, reference).cast<std::pair<double, double>>();
    Command command;
    command.u = {d, ddelta};
    return command;
  }

 private:
  Flush flush_;
  py::object instance_, control_;
  int horizon_;
};

// The manifest's constructors carry no state: one function for each class that may be offered.
constexpr std::size_t most_classes = 512;

void* make(std::size_t slot, const PluginContext* context, const abi::ParamValue* values, char* error,
           std::size_t size) {
  const py::gil_scoped_acquire lock;
  const Offered& plugin = offered()[slot];
  try {
    if (plugin.decl.kind == abi::Kind::estimator)
      return static_cast<Estimator*>(new PythonEstimator(plugin, *context, values));
    return static_cast<Controller*>(new PythonController(plugin, *context, values));
  } catch (const py::error_already_set& thrown) {
    std::snprintf(error, size, "%s", words_of(thrown).c_str());
    return nullptr;
  } catch (const std::exception& thrown) {
    std::snprintf(error, size, "%s", thrown.what());
    return nullptr;
  }
}
template <std::size_t slot>
void* make_slot(const PluginContext* context, const abi::ParamValue* values, char* error, std::size_t size) {
  return make(slot, context, values, error, size);
}
template <std::size_t... slot>
constexpr auto makers(std::index_sequence<slot...>) {
  return std::array{&make_slot<slot>...};
}

template <class Interface>
void destroy(void* plugin) {
  const py::gil_scoped_acquire lock;
  delete static_cast<Interface*>(plugin);
}

using ParamRow = std::tuple<std::string, double, std::string, double, double, std::string>;

void offer(const std::string& kind, const std::string& id, const std::string& version, const std::string& doc,
           const std::string& source, const std::vector<ParamRow>& params, py::object type) {
  static constexpr auto create = makers(std::make_index_sequence<most_classes>());
  if (offered().size() == most_classes) throw InputError("at most 512 Python classes in one process");
  Offered& one = offered().emplace_back();
  one.id = id, one.version = version, one.doc = doc, one.source = source, one.type = std::move(type);
  one.texts.reserve(3 * params.size());
  for (const auto& [name, fallback, unit, low, high, sentence] : params) {
    one.texts.insert(one.texts.end(), {name, unit, sentence});
    const std::string* const texts = &one.texts[one.texts.size() - 3];
    one.params.push_back({texts[0].c_str(), texts[1].c_str(), texts[2].c_str(), abi::ParamType::number, fallback, low,
                          high, nullptr, false, 0, 0, 1, false});
  }
  const bool estimates = kind == "estimator";
  one.decl.kind = estimates ? abi::Kind::estimator : abi::Kind::controller;
  one.decl.id = one.id.c_str();
  one.decl.version = one.version.c_str();
  one.decl.summary = one.doc.c_str();
  one.decl.params = one.params.data();
  one.decl.param_count = one.params.size();
  one.decl.advice = "";
  one.decl.create = create[offered().size() - 1];
  one.decl.destroy = estimates ? &destroy<Estimator> : &destroy<Controller>;
  offer_plugin({&one.decl, one.source});
}

// ---- commands ----

/// A command with its words; what it prints goes to sys.stdout and sys.stderr, or nowhere where `quiet`. The program's
/// exit code; wrong input, plugins that cannot be used and an interrupt are exceptions.
int call(int (*command)(tools::Arguments), const std::vector<std::string>& words, bool quiet) {
  std::optional<py::scoped_ostream_redirect> out, err;
  std::optional<Silence> silence;
  if (quiet) {
    silence.emplace();
  } else {
    out.emplace(std::cout, py::module_::import("sys").attr("stdout"));
    err.emplace(std::cerr, py::module_::import("sys").attr("stderr"));
  }
  StopSignal::forget();  // not every command has a StopSignal: one that an earlier command saw does not count
  int code = tools::good;
  try {
    const WithoutPython other_threads_go_on;
    code = command(words);
  } catch (...) {
    if (!StopSignal::seen()) throw;
  }
  if (StopSignal::seen()) {  // also where the work was done by then: a loop of calls is to end
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  return code;
}

/// A recording of ROS needs libraries that this module has not, and the program that has them would replace this one.
std::unique_ptr<bags::BagFile> refuse_bag(const std::filesystem::path& file) {
  throw InputError(file.string() + ": is a recording of ROS, which the program imports: gripline import " +
                   file.string() + " --map MAP.json --out LOG.gripline.csv");
}
int import_table(tools::Arguments words) { return tools::import_log(words, &refuse_bag); }

struct ModuleCommand {
  const char* name;
  int (*run)(tools::Arguments);
};
constexpr ModuleCommand commands[] = {
    {"compare", tools::run_compare}, {"run", tools::run_one}, {"diagnose", tools::run_diagnose},
    {"predict", tools::run_predict}, {"fit", tools::run_fit}, {"import_log", import_table},
};

/// The stack and the seed of `gripline run` where none are given.
std::pair<std::string, std::uint64_t> first_run(const std::string& file, const std::vector<std::string>& assignments,
                                                const std::vector<std::string>& plugin_folders) {
  const Registry registry(Registry::search_path(plugin_folders));
  const std::filesystem::path experiment = find_shipped(file, "experiments");
  const RaceSpec race = read_race(experiment, load_experiment(experiment, assignments), registry);
  return {race.stacks.front().name, race.seeds.front()};
}

// ---- races step by step ----

constexpr int preview = 8;          // curvatures ahead
constexpr double preview_s = 0.15;  // apart, at the car's reference speed

/// One world, and where asked for what a stack learns in it. A seed draws what it draws in a race: noise, and the
/// experiment's "perturb".
class Race {
 public:
  Race(const std::string& file, const std::string& stack, const std::vector<std::string>& assignments,
       const std::vector<std::string>& plugin_folders)
      : registry_(Registry::search_path(plugin_folders)) {
    const std::filesystem::path experiment = find_shipped(file, "experiments");
    race_.emplace(read_race(experiment, load_experiment(experiment, assignments), registry_));
    if (!stack.empty()) tools::require_stack(*race_, stack);
    for (const StackSpec& one : race_->stacks)
      if (one.name == stack) stack_spec_ = &one;
  }

  /// After one that throws there is no race to go on with, neither the one before nor half of the new one.
  Array reset(std::uint64_t seed) {
    end_episode();
    try {
      begin_episode(seed);
    } catch (...) {
      end_episode();
      throw;
    }
    return observation();
  }

  py::tuple step(double d, double ddelta) {
    if (!world_) throw InputError("reset() comes before step()");
    if (over_) throw InputError("the car has hit a wall: reset() comes before the next step()");
    if (!std::isfinite(d) || !std::isfinite(ddelta)) throw InputError("an action is two finite numbers: d, ddelta");
    const Observation before = world_->observe();
    const double covered = world_->covered();
    const Input u = guard(world_->plant_id(), before.t, [&] { return world_->advance({d, ddelta}); });
    end_->watch();
    const std::optional<Status> status = end_->status();
    const bool broken = status == Status::error;
    if (stack_ && !broken) {
      const Sample sample = stack_->sample(before, u, world_->observe());
      guard(stack_->spec().estimator.id(), world_->time(), [&] { stack_->learn(sample); });
    }
    py::dict info;
    info["t"] = world_->time();
    info["laps"] = world_->laps();
    if (stack_) info["mu"] = total_mu(stack_->belief(world_->time()).mu, car());
    over_ = broken || status == Status::crashed;
    info["crashed"] = over_;
    const bool ended = over_ || world_->outside();
    return py::make_tuple(observation(), broken ? 0.0 : world_->covered() - covered, ended, status && !ended, info);
  }

  Array observation() const {
    Array out(names_count);
    double* const o = out.mutable_data();
    const Observation& now = world_->observe();
    const double length = world_->course().length(), side = now.at.direction;
    o[0] = now.x.vx, o[1] = now.x.vy, o[2] = now.x.omega, o[3] = now.x.delta, o[4] = now.d;
    o[5] = side * now.at.n;
    o[6] = std::remainder(now.x.yaw - now.at.yaw_line - (side < 0 ? std::numbers::pi : 0.0), 2 * std::numbers::pi);
    const CoursePoint here = world_->course().at(now.at.s);
    o[7] = side > 0 ? here.left : here.right, o[8] = side > 0 ? here.right : here.left;
    for (int i = 0; i < preview; ++i) {
      const double ahead = now.at.s + side * preview_s * car().v_ref * i;
      o[9 + i] = side * world_->track().at(ahead - length * std::floor(ahead / length)).kappa;
    }
    return out;
  }
  static std::vector<std::string> observation_names() {
    std::vector<std::string> names = {
        "vx_mps", "vy_mps", "yaw_rate_radps", "delta_rad", "d", "offset_m", "heading_error_rad", "left_m", "right_m"};
    for (int i = 0; i < preview; ++i) names.push_back("kappa" + std::to_string(i) + "_1pm");
    return names;
  }
  std::pair<std::array<double, 2>, std::array<double, 2>> limits() const {
    return {{car().d_min, -car().ddelta_max}, {car().d_max, car().ddelta_max}};
  }
  double dt() const { return race_->world.dt; }
  Array state() const {
    if (!world_) throw InputError("reset() comes before the state");
    return array_of(world_->state());
  }

 private:
  static constexpr py::ssize_t names_count = 9 + preview;
  void end_episode() {
    stack_.reset();
    end_.reset();
    world_.reset();
  }
  void begin_episode(std::uint64_t seed) {
    world_spec_ = race_->world;
    drawn_ = stack_spec_ != nullptr ? *stack_spec_ : race_->stacks.front();
    perturb(race_->perturb, seed, world_spec_, drawn_);
    world_.emplace(world_spec_, seed);
    end_.emplace(*world_);
    over_ = false;
    if (stack_spec_ != nullptr) stack_.emplace(drawn_, stack_context(*world_, {.seed = seed}), world_->observe());
  }
  const Car& car() const { return race_->world.car.car; }

  Registry registry_;
  std::optional<RaceSpec> race_;
  const StackSpec* stack_spec_ = nullptr;
  WorldSpec world_spec_;  // with the draw of the seed
  StackSpec drawn_;
  bool over_ = false;
  std::optional<World> world_;
  std::optional<RaceEnd> end_;
  std::optional<Stack> stack_;
};

/// Races that Python dropped while another thread had its turn. Guarded by the interpreter's lock, never destroyed.
std::vector<Race*>& dropped_races() {
  static auto* const all = new std::vector<Race*>;
  return *all;
}

/// Ends one by one what was dropped: a class of one may drop others. A turn does so at its end.
void end_dropped_races() {
  while (!dropped_races().empty()) {
    Race* const race = dropped_races().back();
    dropped_races().pop_back();
    delete race;
  }
}

/// Python may drop a race while another thread is within plugins: it ends when that one's call does, and the thread
/// that dropped it goes on.
struct EndInTurn {
  void operator()(Race* race) const {
    if (calls == 0 && !one_call.try_lock()) {
      dropped_races().push_back(race);
      return;
    }
    const Turn turn(std::adopt_lock);
    delete race;
  }
};

}  // namespace
}  // namespace gripline::python

PYBIND11_MODULE(_gripline, m) {
  using namespace gripline;
  using namespace gripline::python;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& wrong) {
      PyErr_SetString(PyExc_ValueError, wrong.what());
    } catch (const boost::program_options::error& wrong) {
      PyErr_SetString(PyExc_ValueError, wrong.what());
    }
  });
  pthread_atfork(before_fork, after_fork_here, after_fork_in_child);
  const py::call_guard<Turn> in_turn;
  m.def(
      "set_program", [](const std::string& file, const std::string& prefix) { set_program(file, prefix); }, in_turn);
  m.def("offer", offer, in_turn);
  for (const auto& [name, command] : commands)
    m.def(
        name,
        [command = command](const std::vector<std::string>& words, bool quiet) { return call(command, words, quiet); },
        in_turn);
  m.def("did_you_mean",
        [](const std::string& name, const std::vector<std::string>& names) { return did_you_mean(name, names); });
  m.def("first_run", first_run, in_turn);
  const auto property = [&](auto get) { return py::cpp_function(get, in_turn); };  // pybind11 guards no getter itself
  py::class_<Race, std::unique_ptr<Race, EndInTurn>>(m, "Race")
      .def(py::init<const std::string&, const std::string&, const std::vector<std::string>&,
                    const std::vector<std::string>&>(),
           in_turn)
      .def("reset", &Race::reset, in_turn)
      .def("step", &Race::step, in_turn)
      .def_property_readonly_static("observation_names", [](const py::object&) { return Race::observation_names(); })
      .def_property_readonly("limits", property(&Race::limits))
      .def_property_readonly("dt", property(&Race::dt))
      .def_property_readonly("state", property(&Race::state));
}
