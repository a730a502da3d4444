#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace gripline {

struct Origin;

/// One error in the user's input and its place.
struct Diagnostic {
  std::string file{};  ///< as shown to the user; "--set" for an assignment of the command line; may be empty
  int line = 0;        ///< from 1; 0 when there is no line (a missing file, a command line)
  int column = 0;      ///< from 1, in characters, not bytes
  std::string pointer{};
  std::string message{};
  std::vector<std::string> contexts{};  ///< what was being read, for example "stack gp"; printed in brackets

  /// `file:line:column: /json/pointer: message`; without a line `--set /json/pointer: message` or `file: message`.
  /// Always one line: control characters are escaped, and what is longer than a few lines is cut.
  [[nodiscard]] std::string text() const;
};

/// What is to be said of the value at a place.
[[nodiscard]] Diagnostic diagnostic_at(const Origin& origin, std::string message);

/// The user's input is refused. what() holds one line per error, without a newline at the end.
class InputError : public std::runtime_error {
 public:
  static constexpr int exit_code = 2;
  explicit InputError(std::vector<Diagnostic> diagnostics);
  /// One error at a place.
  InputError(const Origin& origin, std::string message);
  /// An error that belongs to no file, for example a bad command line option.
  explicit InputError(const std::string& message);
  [[nodiscard]] std::span<const Diagnostic> diagnostics() const noexcept { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Collects errors so that the user sees all of them at once. Readers add to it and continue with a valid default;
/// its owner calls throw_if_any() before a value is used.
class Errors {
 public:
  void add(const Origin& origin, std::string message);
  void add(Diagnostic diagnostic);
  /// An error of the machine and not of the input: a plugin that is not installed. Where there are no others,
  /// throw_if_any() gives all of them to `refuse`, which throws what belongs to it.
  using Refuse = void (*)(const std::string& lines);
  void add(const Origin& origin, std::string message, Refuse refuse);
  /// Takes over what another reading step refused.
  void add(const InputError& error);

  /// What is being read from now on ("stack gp"), named in every message until it changes; empty for none. A value
  /// inherited by several stacks is wrong once, and its one message names them all.
  void set_context(std::string context) { context_ = std::move(context); }

  [[nodiscard]] bool empty() const noexcept { return diagnostics_.empty(); }
  /// Different errors so far.
  [[nodiscard]] std::size_t size() const noexcept { return diagnostics_.size() + unlisted_; }
  /// Every call of add() so far, repetitions counted: by it a reader knows whether its own part was good.
  [[nodiscard]] std::size_t added() const noexcept { return added_; }
  /// By file, line and column. The first thousand; a last one counts what follows.
  [[nodiscard]] std::vector<Diagnostic> sorted() const;
  /// Throws InputError with everything collected, sorted; where nothing is wrong with the input, as `refuse` does.
  void throw_if_any() const;

 private:
  std::vector<Diagnostic> diagnostics_;
  std::unordered_map<std::string, std::size_t> known_;  ///< index of an error, by its text
  std::size_t added_ = 0, unlisted_ = 0, of_machine_ = 0;
  Refuse refuse_ = nullptr;  ///< for those of the machine
  std::string context_;
};

/// Text from outside (keys, paths, messages of plugins), made safe for a terminal: control characters become `\x1b`,
/// and long texts are cut.
[[nodiscard]] std::string escape_control(std::string_view text);

/// The candidate most like `name` (fewest insertions, deletions, substitutions and swaps; upper and lower case count
/// as equal), if one is near enough to be what was meant.
[[nodiscard]] std::optional<std::string> nearest(std::string_view name, std::span<const std::string> candidates);

/// `; did you mean "x"?`, else `; known: a, b, c` (the first dozen), else nothing: to be appended to a message.
[[nodiscard]] std::string did_you_mean(std::string_view name, std::span<const std::string> candidates);

}  // namespace gripline
