// The Python package: its example, what it refuses, and the same numbers as the program's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_python {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;

class Python : public testing::Test {
 protected:
  void SetUp() override {
    if (fs::exists(build_dir() / "python/gripline/runs.py")) return;
    ASSERT_EQ(std::getenv("GRIPLINE_REQUIRE_REFERENCE"), nullptr) << "built without pybind11";
    GTEST_SKIP() << "built without pybind11";
  }
  Outcome python(const std::vector<std::string>& words) {
    std::vector<std::string> all = {"/usr/bin/python3"};
    all.insert(all.end(), words.begin(), words.end());
    return run_program(all, {.folder = folder_.path(), .environment = {{"PYTHONPATH", build_dir() / "python"}}});
  }
  Outcome script(const std::string& text) { return python({"-c", "import gripline\nimport numpy as np\n" + text}); }
  Folder folder_;
};

TEST_F(Python, TheExampleRuns) {
  const Outcome outcome = python({source_dir() / "framework/doc/python_example.py"});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("steps a second of CPU"));
  EXPECT_THAT(outcome.out, HasSubstr("crossing: update"));
}

/// The page's blocks of Python in their order, as one program.
TEST_F(Python, ThePagesBlocksRun) {
  const std::string page = contents(source_dir() / "framework/doc/python.md"), fence = "```python\n";
  std::string program;
  int blocks = 0;
  for (std::size_t at = page.find(fence); at != std::string::npos; at = page.find(fence, at + 1), ++blocks) {
    const std::size_t begin = at + fence.size();
    program.append(page, begin, page.find("```", begin) - begin);
  }
  ASSERT_GE(blocks, 2);
  const Outcome outcome = python({"-c", program});
  EXPECT_EQ(outcome.code, 0) << program << outcome.err;
}

TEST_F(Python, RunsAreTheProgramsByteForByte) {
  const std::string experiment = fixture_dir() / "experiments/good.json";
  const Outcome outcome = script("run = gripline.run('" + experiment +
                                 "', 'slow', 1, out='mine')\n"
                                 "assert run.finished and len(run.steps['t_s']) == 51\n"
                                 "assert np.isfinite(run.steps['vx_mps']).all()\n");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  ASSERT_EQ(gripline_with({"run", experiment, "--stack", "slow", "--seed", "1", "--out", folder_ / "programs"}).code,
            0);
  EXPECT_EQ(contents(folder_ / "mine/slow/1/steps.csv"), contents(folder_ / "programs/slow/1/steps.csv"));
}

/// What scripts are told, and that it is a ValueError.
TEST_F(Python, WrongInputIsAValueErrorWithTheProgramsWords) {
  EXPECT_THAT(script("gripline.compare('nowhere.json')").err, HasSubstr("ValueError"));
  const std::string program =
      "def refused(call, *words):\n"
      "    try:\n"
      "        call()\n"
      "    except ValueError as error:\n"
      "        assert all(word in str(error) for word in words), error\n"
      "    else:\n"
      "        raise AssertionError(words)\n"
      "refused(lambda: gripline.compare(FILE, only='slw'), 'did you mean \"slow\"?')\n"
      "refused(lambda: gripline.Race(FILE, 'slw'), 'no stack \"slw\"', 'did you mean \"slow\"?')\n"
      "refused(lambda: gripline.compare(FILE, plugins=[int]), 'derives neither from')\n"
      "refused(lambda: gripline.compare(FILE, plugins=[1]), 'derives neither from')\n"
      "refused(lambda: gripline.compare(FILE, set=['/world/laps=1']), 'maps JSON pointers to values')\n"
      "refused(lambda: gripline.compare(FILE, set={'/world/laps': {1, 2}}), '/world/laps', 'type set')\n"
      "refused(lambda: gripline.Param(5, '1', 0, 2, 'x'), '5', 'outside its range, 0 to 2')\n"
      "refused(lambda: gripline.Param('5'), 'are numbers')\n"
      "race = gripline.Race(FILE)\n"
      "refused(lambda: race.reset(seed=-1), 'a seed', '-1')\n"
      "race.reset(seed=np.int64(1))\n"
      "for action in ((0.3, 0.5, 99.0), [0.3], 0.3, 'go', None):\n"
      "    refused(lambda: race.step(action), 'two numbers, throttle and steering rate', repr(action))\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(Python, ResultsThatAreNotThereAreNamedByTheNearest) {
  const std::string program =
      "one = gripline.run(FILE, 'slow', 1, out='mine', quiet=True)\n"
      "assert repr(one) == '<Run mine/slow/1: finished, 51 rows of steps>', one\n"
      "def told(call):\n"
      "    try: call()\n"
      "    except ValueError as error: return str(error)\n"
      "assert 'is not a run' in told(lambda: gripline.load_run('nothing'))\n"
      "assert 'did you mean \"mine\"?' in told(lambda: gripline.load_run('mien/slow/1'))\n"
      "assert 'did you mean \"slow\"?' in told(lambda: gripline.load_run('mine/slw/1'))\n"
      "assert 'in it: slow' in told(lambda: gripline.load_run('mine'))\n"
      "assert 'did you mean \"runs\"?' in told(lambda: gripline.load_table('mine', 'run'))\n"
      "assert 'did you mean \"mine\"?' in told(lambda: gripline.load_table('mien'))\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");  // quiet
}

TEST_F(Python, ValuesOfNumPyAndPathsAreSet) {
  const std::string program =
      "from pathlib import Path\n"
      "done = gripline.compare(FILE, only=np.array(['slow']), out=Path('o'), quiet=True,\n"
      "                        set={'/seeds/count': np.int64(1), '/base/mu_init': np.float32(0.5), '/claims': [],\n"
      "                             '/world/friction': [{'t': np.float64(0), 'factor': np.array(0.5)}]})\n"
      "assert [str(one) for one in done.runs['stack']] == ['slow']\n"
      "written = open('o/slow/1/config.json').read()\n"
      "assert '\"mu_init\": 0.5' in written and '\"factor\": 0.5' in written, written\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
}

/// With a map, and without; arguments that are wrong are the command's to refuse.
TEST_F(Python, LogsArePredictedFittedAndImported) {
  write_text(folder_ / "map.json",
             R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "yaw": "yaw_rad", "vx": "vx_mps", "vy": "vy_mps",
                "yaw_rate": "yaw_rate_radps", "d": "d", "delta": "delta_rad"}})");
  const std::string program =
      "from pathlib import Path\n"
      "gripline.run(FILE, 'slow', 1, out='o', set={'/world/duration': 12}, quiet=True)\n"
      "log = 'o/slow/1/steps.csv'\n"
      "table = gripline.predict(WORLD, log, horizon=[0.1, 0.2], map='map.json', samples='s.csv', quiet=True)\n"
      "assert sorted({float(h) for h in table['horizon_s']}) == [0.1, 0.2], table\n"
      "assert str(list(table['model'])[3]) == 'this world', table\n"
      "assert Path('s.csv').is_file()\n"
      "own = gripline.import_log(log, map='map.json', quiet=True)\n"
      "assert own == Path('steps.gripline.csv') and own.is_file()\n"
      "fitted = gripline.fit(WORLD, [own], fit=['observer'], starts=20, quiet=True)\n"
      "assert fitted == Path('fitted.json')\n"
      "kept = gripline.predict(fitted, own, horizon=0.1, fixed=True, out='errors.csv', quiet=True)\n"
      "assert len(kept['model']) == 4 and Path('errors.csv').is_file()\n"
      "def told(call):\n"
      "    try: call()\n"
      "    except ValueError as error: return str(error)\n"
      "assert 'no.json: no such file' in told(lambda: gripline.diagnose(WORLD, log, map='no.json'))\n"
      "assert 'no.csv: no such file' in told(lambda: gripline.diagnose(WORLD, log, track='no.csv'))\n"
      "assert 'no.csv: no such file' in told(lambda: gripline.diagnose(WORLD, log, held_out='no.csv'))\n"
      "assert '--case does not go with --map' in told(\n"
      "    lambda: gripline.diagnose(WORLD, log, map='map.json', case='map.json'))\n"
      "assert 'no.csv' in told(lambda: gripline.predict(WORLD, 'no.csv'))\n"
      "assert 'did you mean \"observer\"?' in told(lambda: gripline.fit(WORLD, log, fit='obsrver'))\n"
      "Path('drive.bag').write_text('#ROSBAG V2.0')\n"
      "assert 'gripline import drive.bag' in told(lambda: gripline.import_log('drive.bag', map='map.json'))\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\nWORLD = '" +
                                 (fixture_dir() / "worlds/short.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(Python, AnExceptionOfAClassEndsItsRunAlone) {
  const Outcome outcome = script(
      "class Bad(gripline.Controller):\n"
      "    id = 'bad'\n"
      "    horizon = 2\n"
      "    def control(self, now, reference):\n"
      "        raise KeyError('no map')\n"
      "try:\n"
      "    gripline.compare('" +
      (fixture_dir() / "experiments/good.json").string() +
      "', plugins=[Bad], out='o', set={'/claims': [], '/stacks/bad': {'controller': {'plugin': 'bad'}}})\n"
      "except RuntimeError as error:\n"
      "    print('told:', error)\n"
      "    runs = gripline.load_table('o', 'runs')\n"
      "    print({str(stack): str(status) for stack, status in zip(runs['stack'], runs['status'])})\n");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("told: a run broke: bad, seed 1: plugin_error: bad at t = 0.000000 s: KeyError: "
                                     "'no map' | <string>:7 in control\n"));
  EXPECT_THAT(outcome.err, testing::Not(HasSubstr("\\x0a")));
  EXPECT_THAT(outcome.out, HasSubstr("'slow': 'finished'"));
  EXPECT_THAT(outcome.out, HasSubstr("'bad': 'plugin_error'"));
}

/// Also where it is made, and with nothing printed but what it prints itself, which is its run's.
TEST_F(Python, AClassThatIsNotWrittenOrCannotBeMadeSaysSo) {
  const std::string program =
      "class Bare(gripline.Estimator):\n"
      "    id = 'bare'\n"
      "class Unmade(gripline.Estimator):\n"
      "    id = 'unmade'\n"
      "    def __init__(self, context, **params):\n"
      "        print('begun')\n"
      "        raise OSError('two\\nlines')\n"
      "def told(one):\n"
      "    try:\n"
      "        gripline.compare(FILE, only='slow', plugins=[one], out=one.id, quiet=True,\n"
      "                         set={'/claims': [], '/stacks/slow': {'estimator': {'plugin': one.id}}})\n"
      "    except RuntimeError as error:\n"
      "        return str(error)\n"
      "assert 'NotImplementedError: update() is not written | ' in told(Bare), told(Bare)\n"
      "assert 'OSError: two | lines | <string>:' in told(Unmade), told(Unmade)\n"
      "assert 'begun' in open('unmade/slow/1/log.txt').read()\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(Python, AnotherInterpreterIsToldWhichOneIsMeant) {
  for (const auto& file : fs::directory_iterator(source_dir() / "python/gripline"))
    if (file.path().extension() == ".py")
      write_text(folder_ / "gripline" / file.path().filename(), contents(file.path()));
  write_text(folder_ / "gripline/_gripline.cpython-39-x86_64-linux-gnu.so", "");
  const Outcome outcome = run_program({"/usr/bin/python3", "-c", "import gripline"},
                                      {.folder = folder_.path(), .environment = {{"PYTHONPATH", folder_.path()}}});
  EXPECT_THAT(outcome.err, HasSubstr("ImportError: gripline runs in the Python that it was built for "
                                     "(_gripline.cpython-39-x86_64-linux-gnu.so"));
  EXPECT_THAT(outcome.err, HasSubstr("/usr/bin/python3 with python3-numpy. This is Python 3."));
}

TEST_F(Python, AChangedClassIsRacedAgainAndItsWordsAreKept) {
  const std::string program =
      "def race(throttle):\n"
      "    class Mine(gripline.Controller):\n"
      "        id = 'mine'\n"
      "        push = throttle\n"
      "        def control(self, now, reference):\n"
      "            print('push', self.push)\n"
      "            return self.push, 0.0\n"
      "    done = gripline.compare(FILE, only='slow', plugins=[Mine], out='o', set={'/claims': [],\n"
      "                            '/stacks/slow': {'controller': {'plugin': 'mine'}}})\n"
      "    return done.run('slow').steps['d'][5]\n"
      "assert race(0.25) == 0.25\n"
      "assert race(0.5) == 0.5\n"
      "assert 'push 0.5' in open('o/slow/1/log.txt').read()\n";
  const std::string file = fixture_dir() / "experiments/good.json";
  std::string text = "FILE = '";
  text.append(file).append("'\n").append(program);
  const Outcome outcome = script(text);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("already there")));
}

/// Threads of the program go on during a command, also one that holds the interpreter's lock as runs are forked; a call
/// from another thread waits for its turn.
TEST_F(Python, OtherThreadsGoOnDuringACommand) {
  const std::string program =
      "import threading, time\n"
      "class Idle(gripline.Estimator):\n"
      "    id = 'idle'\n"
      "    def update(self, sample): self.seen = sample['t']\n"
      "ticks, over = 0, False\n"
      "def tick():\n"
      "    global ticks\n"
      "    while not over:\n"
      "        time.sleep(0.01)\n"
      "        ticks += 1\n"
      "def spin():\n"
      "    while not over: sum(range(100))\n"
      "def races(out):\n"
      "    gripline.compare(FILE, plugins=[Idle], out=out, set={'/claims': [], '/world/duration': 5,\n"
      "                     '/stacks/slow': {'estimator': {'plugin': 'idle'}}})\n"
      "for one in (tick, spin): threading.Thread(target=one, daemon=True).start()\n"
      "begun, before = time.time(), ticks\n"
      "races('alone')\n"
      "seen, took = ticks - before, time.time() - begun\n"
      "assert seen > 10 * took, (seen, took)  # a hundred a second at best\n"
      "both = [threading.Thread(target=races, args=[out], daemon=True) for out in ('one', 'two')]\n"
      "for one in both: one.start()\n"
      "for one in both: one.join()\n"
      "over = True\n"
      "for out in ('alone', 'one', 'two'):\n"
      "    states = [str(status) for status in gripline.load_table(out, 'runs')['status']]\n"
      "    assert states == 4 * ['finished'], states\n";
  std::string text = "FILE = '";
  text.append((fixture_dir() / "experiments/good.json").string()).append("'\n").append(program);
  const Outcome outcome = script(text);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

/// It ends its own call: the same call goes on, and one that notes no signal itself does not end by an earlier one.
TEST_F(Python, AnInterruptEndsItsOwnCallAlone) {
  const std::string program =
      "import os, signal\n"
      "program = os.getpid()\n"
      "class Stop(gripline.Estimator):\n"
      "    id = 'stop'\n"
      "    pressed = False\n"
      "    def update(self, sample):\n"
      "        if not (Stop.pressed or os.path.exists('pressed')):\n"
      "            Stop.pressed = True\n"
      "            open('pressed', 'w').close()\n"
      "            os.kill(program, signal.SIGINT)\n"
      "def race():\n"
      "    return gripline.compare(FILE, only='slow', plugins=[Stop], out='o', quiet=True, set={'/claims': [],\n"
      "                            '/world/duration': 12, '/stacks/slow': {'estimator': {'plugin': 'stop'}}})\n"
      "try: race()\n"
      "except KeyboardInterrupt: print('interrupted')\n"
      "log = race().out / 'slow/1/steps.csv'\n"
      "assert len(gripline.predict(WORLD, log, horizon=0.1, quiet=True)['model']) == 4\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\nWORLD = '" +
                                 (fixture_dir() / "worlds/short.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "interrupted\n");
}

/// A race that is dropped, as the garbage collector does in any thread, ends with that command.
TEST_F(Python, ARaceIsDroppedDuringACommandWithoutWaiting) {
  const std::string program =
      "import os, threading, time\n"
      "ended = []\n"
      "class Told(gripline.Estimator):\n"
      "    id = 'noted'\n"
      "    def update(self, sample): pass\n"
      "    def __del__(self): ended.append(self)\n"
      "class Slow(gripline.Estimator):\n"
      "    id = 'sleepy'\n"
      "    def update(self, sample): time.sleep(0.05)\n"
      "race = gripline.Race(FILE, 'slow', plugins=[Told], set={'/stacks/slow': {'estimator': {'plugin': 'noted'}}})\n"
      "race.reset(seed=1)\n"
      "before = len(ended)\n"
      "other = threading.Thread(target=lambda: gripline.compare(FILE, only='slow', plugins=[Slow], out='o', "
      "quiet=True,\n"
      "    set={'/claims': [], '/stacks/slow': {'estimator': {'plugin': 'sleepy'}}}))\n"
      "other.start()\n"
      "while not os.path.exists('o'): time.sleep(0.01)\n"
      "del race\n"
      "assert other.is_alive() and len(ended) == before, ended\n"
      "other.join()\n"
      "assert len(ended) == before + 1, ended\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

/// Quiet commands within quiet ones: what classes of the inner one print is in the logs of its runs.
TEST_F(Python, AClassMayCallAQuietCommand) {
  const std::string program =
      "import os\n"
      "out = os.path.abspath('inner')\n"
      "def race(one, folder):\n"
      "    gripline.compare(FILE, only='slow', plugins=[one], out=folder, quiet=True, force=True,\n"
      "                     set={'/claims': [], '/stacks/slow': {'estimator': {'plugin': one.id}}})\n"
      "class Inner(gripline.Estimator):\n"
      "    id = 'inner'\n"
      "    def update(self, sample): print('inner', sample['t'])\n"
      "class Outer(gripline.Estimator):\n"
      "    id = 'outer'\n"
      "    raced = False\n"
      "    def update(self, sample):\n"
      "        print('outer', sample['t'])\n"
      "        if not Outer.raced: race(Inner, out)\n"
      "        Outer.raced = True\n"
      "race(Outer, 'outer')\n"
      "for one in ('inner', 'outer'): assert one + ' 0' in open(one + '/slow/1/log.txt').read(), one\n";
  const Outcome outcome = script("FILE = '" + (fixture_dir() / "experiments/good.json").string() + "'\n" + program);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(Python, ARaceIsAnEnvironmentOfGymnasiumWhereThatIsInstalled) {
  write_text(folder_ / "gymnasium/__init__.py",
             "class Env:\n"
             "    def reset(self, *, seed=None, options=None):\n"
             "        self.np_random_seed = seed\n"
             "class spaces:\n"
             "    class Box:\n"
             "        def __init__(self, low, high, shape=None, dtype=None):\n"
             "            self.low, self.high, self.shape = low, high, shape\n");
  std::string text =
      "import sys; sys.path.insert(0, '.')\nimport importlib, gymnasium\n"
      "import gripline.stepping; importlib.reload(gripline.stepping)\n"
      "race = gripline.stepping.Race('";
  text.append((fixture_dir() / "experiments/good.json").string());
  text.append(
      "')\n"
      "assert isinstance(race, gymnasium.Env)\n"
      "observation, info = race.reset(seed=3)\n"
      "assert race.np_random_seed == 3 and info['seed'] == 3\n"
      "assert race.observation_space.shape == observation.shape\n"
      "assert list(race.action_space.low) == list(race.action_low)\n"
      "assert race.reset()[1]['seed'] == 4\n");
  const Outcome outcome = script(text);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(Python, AStandingCarEndsAnEpisodeAsItEndsARace) {
  const Outcome outcome = script("race = gripline.Race('" + (fixture_dir() / "experiments/good.json").string() +
                                 "', set={'/world/duration': 8, '/world/start/speed': 0})\n"
                                 "race.reset(seed=1)\n"
                                 "ended = False\n"
                                 "while not ended:\n"
                                 "    _, _, terminated, ended, info = race.step((0.0, 0.0))\n"
                                 "    assert not terminated\n"
                                 "assert abs(info['t'] - 5) < 0.03, info\n");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

/// As in a race, what is no friction is refused and not believed.
TEST_F(Python, AnEstimatorThatFailsIsNamedInAStep) {
  const Outcome outcome = script(
      "class Lost(gripline.Estimator):\n"
      "    id = 'lost'\n"
      "    def update(self, sample):\n"
      "        pass\n"
      "    def belief(self):\n"
      "        return float('nan'), 1.0\n"
      "race = gripline.Race('" +
      (fixture_dir() / "experiments/good.json").string() +
      "', 'lost', plugins=[Lost], set={'/stacks/lost': {'estimator': {'plugin': 'lost'}}})\n"
      "race.reset(seed=1)\n"
      "race.step((0.3, 0.0))\n");
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("RuntimeError: lost at t = 0.020000 s: returned a friction that is not a number"));
}

/// Neither the race before nor a world without its stack goes on.
TEST_F(Python, AResetThatFailsLeavesNoRace) {
  const Outcome outcome = script(
      "class Moody(gripline.Estimator):\n"
      "    id = 'moody'\n"
      "    fails = False\n"
      "    def __init__(self, context, **params):\n"
      "        super().__init__(context, **params)\n"
      "        if Moody.fails: raise ValueError('not today')\n"
      "    def update(self, sample):\n"
      "        pass\n"
      "race = gripline.Race('" +
      (fixture_dir() / "experiments/good.json").string() +
      "', 'moody', plugins=[Moody], set={'/stacks/moody': {'estimator': {'plugin': 'moody'}}})\n"
      "race.reset(seed=1)\n"
      "race.step((0.3, 0.0))\n"
      "def refusal(call):\n"
      "    try: call()\n"
      "    except Exception as refused: return str(refused)\n"
      "    return 'nothing'\n"
      "Moody.fails = True\n"
      "assert 'not today' in refusal(lambda: race.reset(seed=2))\n"
      "assert 'reset() comes before step()' in refusal(lambda: race.step((0.3, 0.0)))\n"
      "assert 'reset() comes before the state' in refusal(lambda: race.state)\n"
      "Moody.fails = False\n"
      "race.reset(seed=2)\n"
      "assert race.step((0.3, 0.0))[4]['mu'] > 0\n");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(Python, RacesAreRepeatedBySeedAndEnd) {
  const Outcome outcome = script("race = gripline.Race('" + (fixture_dir() / "experiments/good.json").string() +
                                 "', 'told')\n"
                                 "def drive(seed):\n"
                                 "    race.reset(seed=seed)\n"
                                 "    out = [race.step((0.3, 0.1)) for _ in range(20)]\n"
                                 "    return np.array([o[0] for o in out]), out[-1]\n"
                                 "a, last = drive(1)\n"
                                 "b, _ = drive(1)\n"
                                 "assert (a == b).all() and a.shape == (20, len(race.observation_names))\n"
                                 "assert last[4]['mu'] > 0.5, last\n"
                                 "done = False\n"
                                 "for k in range(200):\n"
                                 "    _, _, terminated, truncated, info = race.step((1.0, 5.0))\n"
                                 "    if terminated or truncated: break\n"
                                 "assert (terminated or truncated) and k < 199\n");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

}  // namespace test_python
}  // namespace gripline
