#include "util/progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <string_view>
#include <utility>

namespace gripline {
namespace {

constexpr double quiet_seconds = 2.0;        // work shorter than this needs no progress
constexpr double plain_period_seconds = 30;  // longest time between two lines of a piped log
constexpr auto frame = std::chrono::milliseconds(100);

std::string_view environment(const char* name) {
  const char* text = std::getenv(name);
  return text ? text : "";
}

std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

std::size_t columns(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return !continues(c); }));
}

/// At most `limit` characters of UTF-8 text, cut between characters.
std::string cut(const std::string& text, std::size_t limit) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (!continues(text[i]) && seen++ == limit) return text.substr(0, i);
  return text;
}

std::string two_digits(long value) { return (value < 10 ? "0" : "") + std::to_string(value); }

std::string bar(double share, std::size_t width, bool unicode) {
  constexpr const char* eighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const auto filled = static_cast<std::size_t>(share * 8 * static_cast<double>(width));
  std::string text;
  for (std::size_t i = 0; i < filled / 8; ++i) text += unicode ? "█" : "#";
  std::size_t used = filled / 8;
  if (unicode && filled % 8 != 0) {
    text += eighths[filled % 8];
    ++used;
  }
  for (; used < width; ++used) text += unicode ? "░" : "-";
  return text;
}

int descriptor_of(const std::ostream& out) {
  if (&out == &std::cout) return STDOUT_FILENO;
  if (&out == &std::cerr || &out == &std::clog) return STDERR_FILENO;
  return -1;
}

}  // namespace

Terminal detect_terminal(int fd) {
  Terminal terminal;
  terminal.live = fd >= 0 && isatty(fd) == 1 && environment("TERM") != "dumb";
  terminal.colour = terminal.live && environment("NO_COLOR").empty();
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const std::string_view locale = environment(name);
    if (locale.empty()) continue;
    terminal.unicode = locale.find("UTF-8") != locale.npos || locale.find("utf8") != locale.npos;
    break;
  }
  winsize size{};
  if (terminal.live && ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) terminal.width = size.ws_col;
  return terminal;
}

std::string duration_text(double seconds) {
  const long whole = std::lround(std::clamp(seconds, 0.0, 1e9));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + two_digits(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + two_digits(whole % 3600 / 60) + " min";
}

Progress::Progress(std::ostream& out, std::string title, std::size_t total)
    : Progress(out, std::move(title), total, detect_terminal(descriptor_of(out)), Clock::now()) {}

Progress::Progress(std::ostream& out, std::string title, std::size_t total, Terminal terminal, Clock::time_point start)
    : out_(out),
      title_(printable(std::move(title))),
      total_(std::max<std::size_t>(total, 1)),
      terminal_(terminal),
      start_(start),
      drawn_(start) {}

Progress::~Progress() {
  if (!finished_ && terminal_.live && any_drawn_)
    out_ << "\r\x1b[K" << title_ << ": stopped at " << counted() << std::endl;
}

/// Below 0 until enough is done to tell: what comes before the work proper counts most at its start.
double Progress::left(double elapsed) const {
  constexpr double enough = 0.05, enough_later = 0.005, later = 60.0;  // shares of the work, [s]
  const double share = static_cast<double>(done_) / static_cast<double>(total_);
  const bool told = share >= enough || (elapsed >= later && share >= enough_later);
  return !told ? -1 : elapsed / static_cast<double>(done_) * static_cast<double>(total_ - done_);
}

std::string Progress::counted() const {
  return std::to_string(done_ / counted_in_) + " of " + std::to_string(total_ / counted_in_);
}

void Progress::advance(std::size_t done, std::string note) { advance_at(Clock::now(), done, std::move(note)); }

void Progress::advance_at(Clock::time_point now, std::size_t done, std::string note) {
  if (finished_) return;
  done_ = std::min(done, total_);
  note_ = printable(std::move(note));
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  if (!terminal_.live) return print_plain(elapsed);
  if (any_drawn_ && now - drawn_ < frame) return;
  drawn_ = now;
  draw_live(elapsed);
}

// Title, bar, share, time left, note; the bar gives way first, then the note.
void Progress::draw_live(double elapsed) {
  any_drawn_ = true;
  const double share = static_cast<double>(done_) / static_cast<double>(total_);
  const double rest = left(elapsed);
  std::string text = counted();
  text += rest < 0 ? ", " + duration_text(elapsed) + " so far" : ", " + duration_text(rest) + " left";
  const auto room = static_cast<std::size_t>(std::max(terminal_.width - 1, 10));
  const std::string title = cut(title_, room / 3);
  const std::size_t fixed = columns(title) + columns(text) + 4;
  const std::size_t bar_width = fixed + 8 > room ? 0 : std::min<std::size_t>(24, (room - fixed) / 2);
  std::string line = title + "  ";
  if (bar_width >= 4) {
    const std::string drawn = bar(share, bar_width, terminal_.unicode);
    line += (terminal_.colour ? "\x1b[36m" + drawn + "\x1b[0m" : drawn) + "  ";
  }
  const std::size_t used = columns(title) + 2 + (bar_width >= 4 ? bar_width + 2 : 0);
  std::string tail = note_.empty() ? text : text + "  " + note_;
  tail = cut(tail, room > used ? room - used : 0);
  out_ << '\r' << line << tail << "\x1b[K" << std::flush;
}

// One line per tenth of the work, or one per half minute when a tenth takes longer; none twice.
void Progress::print_plain(double elapsed) {
  const std::size_t tenth = done_ * 10 / total_;
  if (elapsed < quiet_seconds || done_ == total_) return;
  if (any_drawn_ && tenth == printed_tenth_ && elapsed - printed_at_ < plain_period_seconds) return;
  any_drawn_ = true;
  printed_tenth_ = tenth;
  printed_at_ = elapsed;
  const double rest = left(elapsed);
  std::string line = title_ + ": " + counted();
  line += rest < 0 ? ", " + duration_text(elapsed) + " so far" : ", " + duration_text(rest) + " left";
  if (!note_.empty()) line += " (" + note_ + ")";
  if (line == printed_) return;
  printed_ = line;
  out_ << line << std::endl;
}

void Progress::finish() { finish_at(Clock::now()); }

void Progress::finish_at(Clock::time_point now) {
  if (finished_) return;
  finished_ = true;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  if (terminal_.live) out_ << "\r\x1b[K";
  if (elapsed >= quiet_seconds) out_ << title_ << ": " << counted() << " in " << duration_text(elapsed) << '\n';
  out_ << std::flush;
}

CallbackProgress::CallbackProgress(std::ostream& out, std::string title)
    : CallbackProgress(out, std::move(title), detect_terminal(descriptor_of(out)), Progress::Clock::now()) {}

CallbackProgress::CallbackProgress(std::ostream& out, std::string title, Terminal terminal,
                                   Progress::Clock::time_point start)
    : out_(out), title_(std::move(title)), terminal_(terminal), start_(start) {}

ProgressCallback CallbackProgress::callback() {
  constexpr std::size_t units = 1000;  // of one part
  return [this](double done, std::size_t total, const std::string& what) {
    if (!progress_) progress_.emplace(out_, title_, total * units, terminal_, start_).count_in(units);
    progress_->advance(static_cast<std::size_t>(std::max(done, 0.0) * units), what);
  };
}

void CallbackProgress::finish() {
  if (!progress_) return;
  progress_->advance(std::numeric_limits<std::size_t>::max());  // clamped to the total
  progress_->finish();
}

}  // namespace gripline
