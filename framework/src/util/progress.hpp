// Progress of long work on a terminal: one line that redraws itself, with the time left; plain lines when piped.
//
//   Progress progress(std::cerr, "table1", runs.size());
//   while (...) progress.advance(done, "elm, seed 3");   // as often as you like; repeated values update the time
//   progress.finish();
//
// Nothing is printed by work that ends within two seconds of starting, unless the line is a live one. Not thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

namespace gripline {

/// What a stream can show. `live`: the line may be redrawn with carriage returns. `width` in columns.
struct Terminal {
  bool live = false;
  bool colour = false;
  bool unicode = false;
  int width = 80;
};

/// Looks at file descriptor `fd` (isatty, window size) and at the environment: TERM=dumb is not live, a non-empty
/// NO_COLOR (https://no-color.org) takes colours away, LC_ALL, LC_CTYPE or LANG decide about block characters.
Terminal detect_terminal(int fd);

/// A duration for people: "8 s", "2 min 05 s", "1 h 04 min".
std::string duration_text(double seconds);

class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  /// `out` is std::cout, std::cerr or std::clog (asked about its terminal) or any other stream (plain lines).
  /// `total` is the amount of work in any unit, at least 1.
  Progress(std::ostream& out, std::string title, std::size_t total);
  Progress(std::ostream& out, std::string title, std::size_t total, Terminal terminal, Clock::time_point start);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Leaves a clean line behind when the work ended early.
  ~Progress();

  /// How many units make one of what is shown: with 1000, done = 1000 of 4000 reads "1 of 4".
  void count_in(std::size_t units) { counted_in_ = units > 0 ? units : 1; }

  /// `done` units of `total` are finished; `note` says what is under way. Control characters are replaced by spaces.
  void advance(std::size_t done, std::string note = {});
  /// advance() as if called at the instant `now`, for tests.
  void advance_at(Clock::time_point now, std::size_t done, std::string note);

  /// All is done: the live line becomes a summary with the time taken, a plain one is printed if two seconds passed.
  void finish();
  void finish_at(Clock::time_point now);

 private:
  double left(double elapsed) const;
  std::string counted() const;
  void draw_live(double elapsed);
  void print_plain(double elapsed);

  std::ostream& out_;
  std::string title_, note_, printed_;  // printed_: the last plain line
  std::size_t total_, done_ = 0, counted_in_ = 1;
  Terminal terminal_;
  Clock::time_point start_, drawn_;
  std::size_t printed_tenth_ = 0;
  double printed_at_ = 0;
  bool any_drawn_ = false, finished_ = false;
};

/// Called by long work: `done` of `total` parts are finished, fractions included; `what` is under way.
using ProgressCallback = std::function<void(double done, std::size_t total, const std::string& what)>;

/// A Progress driven by a ProgressCallback: it begins with the first call, which says how many parts there are.
class CallbackProgress {
 public:
  CallbackProgress(std::ostream& out, std::string title);
  CallbackProgress(std::ostream& out, std::string title, Terminal terminal, Progress::Clock::time_point start);
  /// To be given to the work; this object must outlive it.
  ProgressCallback callback();
  void finish();

 private:
  std::ostream& out_;
  std::string title_;
  Terminal terminal_;
  Progress::Clock::time_point start_;
  std::optional<Progress> progress_;
};

}  // namespace gripline
