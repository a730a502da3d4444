#include "experiment/claims.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "experiment/race_columns.hpp"

namespace gripline {
namespace {

/// What is wrong with a claim's text; read_claim() says where the claim stands.
struct ClaimProblem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class TermParser {
 public:
  explicit TermParser(std::string_view text) : text_(text) {}
  /// Throws ClaimProblem.
  ClaimTerm parse() {
    ClaimTerm term;
    skip();
    const std::size_t begin = at_;
    if (const std::optional<double> number = read_number()) {
      const std::size_t end = at_;
      skip();
      if (at_ == text_.size()) return {0.0, "", "", *number};
      if (accept('*'))
        term.factor = *number;
      else if (at_ > end && std::isalnum(static_cast<unsigned char>(text_[at_])) != 0)
        refuse_factor(begin, end);
      else
        at_ = begin;  // a name that begins with digits
    }
    skip();
    term.stack = stack_name();
    term.column = name("_");  // "a.x-1" subtracts
    skip();
    if (accept('+'))
      term.offset = required_number();
    else if (accept('-'))
      term.offset = -required_number();
    finish(term);
    return term;
  }

 private:
  /// A number and a name with nothing but a blank between them.
  [[noreturn]] void refuse_factor(std::size_t begin, std::size_t end) const {
    const std::string_view rest = text_.substr(at_, text_.find_last_not_of(' ') + 1 - at_);
    throw ClaimProblem("a factor stands before \"*\": write " + std::string(text_.substr(begin, end - begin)) + " * " +
                       std::string(rest));
  }
  void skip() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  bool accept(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  /// Everything before the last dot that a letter follows: stack names may have dots ("w0.3"), column names begin with
  /// a letter, and a subtracted number ("a.x-0.5") begins with a digit.
  std::string stack_name() {
    const std::size_t begin = at_;
    const std::string all = name("_-.");
    std::size_t dot = all.size();
    for (std::size_t i = 1; i + 1 < all.size(); ++i)
      if (all[i] == '.' && std::isalpha(static_cast<unsigned char>(all[i + 1])) != 0) dot = i;
    if (dot == all.size()) throw ClaimProblem("expected stack.column, found \"" + std::string(text_) + "\"");
    at_ = begin + dot + 1;
    return all.substr(0, dot);
  }
  std::string name(std::string_view besides) {
    const std::size_t begin = at_;
    const auto part = [&](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || besides.find(c) != besides.npos;
    };
    while (at_ < text_.size() && part(text_[at_])) ++at_;
    if (begin == at_) throw ClaimProblem("expected a name in \"" + std::string(text_) + "\"");
    return std::string(text_.substr(begin, at_ - begin));
  }
  std::optional<double> read_number() {
    double number = 0.0;
    const auto [end, code] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (code != std::errc() || !std::isfinite(number)) return std::nullopt;
    at_ = static_cast<std::size_t>(end - text_.data());
    return number;
  }
  double required_number() {
    skip();
    const std::optional<double> number = read_number();
    if (!number) throw ClaimProblem("expected a number in \"" + std::string(text_) + "\"");
    return *number;
  }
  /// Refuses what follows a term. A factor behind the column is shown before it.
  void finish(const ClaimTerm& term) {
    skip();
    if (at_ == text_.size()) return;
    const std::string rest(text_.substr(at_));
    const bool bare = term.factor == 1.0 && term.offset == 0.0;
    if (bare && accept('*')) {
      skip();
      const std::optional<double> factor = read_number();
      skip();
      if (factor && at_ == text_.size())
        throw ClaimProblem("a factor stands before \"*\": write " + number_text(*factor) + " * " + term.stack + "." +
                           term.column);
    }
    throw ClaimProblem("cannot read \"" + rest + "\"; a side of a claim is [number *] stack.column [+|- number]");
  }
  std::string_view text_;
  std::size_t at_ = 0;
};

struct RelationName {
  const char* text;
  Claim::Relation relation;
};
constexpr RelationName relations[] = {{"<=", Claim::Relation::less_equal},
                                      {">=", Claim::Relation::greater_equal},
                                      {"==", Claim::Relation::equal},
                                      {"<", Claim::Relation::less},
                                      {">", Claim::Relation::greater}};

/// How a relation is not written; empty where the text has none of these.
std::string misspelt_relation(const std::string& text) {
  for (const auto& [wrong, right] : {std::pair("=<", "<="), {"=>", ">="}, {"\u2264", "<="}, {"\u2265", ">="}})
    if (text.find(wrong) != std::string::npos) return std::string("\"") + wrong + "\" is written \"" + right + '"';
  return {};
}

void check_names(const ClaimTerm& term, std::span<const std::string> stacks, std::span<const std::string> columns,
                 const Node& node, Errors& errors) {
  if (term.stack.empty()) return;
  if (std::find(stacks.begin(), stacks.end(), term.stack) == stacks.end())
    errors.add(node.origin, "no stack \"" + term.stack + "\"" + did_you_mean(term.stack, stacks));
  const auto is_known = [&](const std::string& column) {
    return columns.empty() ? is_table_column(column) : std::ranges::find(columns, column) != columns.end();
  };
  if (is_known(term.column)) return;
  const std::string no = "no column \"" + term.column + '"';
  for (const char* unit : {"_s", "_m", "_mps", "_ms"})  // left out of the name
    if (is_known(term.column + unit))
      return errors.add(node.origin, no + "; did you mean \"" + term.column + unit + "\"?");
  const std::vector<std::string> of_race =
      columns.empty() ? race_column_names("table.csv", 1) : std::vector<std::string>();
  errors.add(node.origin, no + did_you_mean(term.column, columns.empty() ? of_race : columns));
}

bool compare(double left, Claim::Relation relation, double right) {
  switch (relation) {
    case Claim::Relation::less:
      return left < right;
    case Claim::Relation::less_equal:
      return left <= right;
    case Claim::Relation::greater:
      return left > right;
    case Claim::Relation::greater_equal:
      return left >= right;
    case Claim::Relation::equal:
      return left == right;
  }
  return false;
}

std::optional<double> evaluate(const ClaimTerm& term, int run, const ClaimLookup& lookup) {
  if (term.stack.empty()) return term.offset;
  const std::optional<double> value = lookup(term.stack, term.column, run);
  if (!value) return std::nullopt;
  return term.factor * *value + term.offset;
}

}  // namespace

bool Claim::about_time() const {
  const auto timed = [](const ClaimTerm& term) {
    return term.column.starts_with("solve_ms") || term.column.starts_with("update_ms") || term.column == "cpu_s";
  };
  return timed(left) || timed(right);
}

bool Claim::about_single_runs() const {
  const auto over_runs = [](const ClaimTerm& term) {
    const std::optional<NamedColumn> named = find_race_column(term.column);
    return named && named->column->sum != RowSum::median;
  };
  return !about_interval() && !over_runs(left) && !over_runs(right);
}

bool Claim::about_interval() const { return !interval_of(left.column).empty() || !interval_of(right.column).empty(); }

std::optional<Claim> read_claim(const Node& node, std::span<const std::string> stacks, Errors& errors,
                                std::span<const std::string> columns) {
  if (!node.is_text()) {
    errors.add(node.origin, "expected a claim such as \"a.violation_s <= b.violation_s\", found " + node.describe());
    return std::nullopt;
  }
  Claim claim;
  claim.text = node.text();
  claim.at = node.origin;
  if (const std::string problem = misspelt_relation(claim.text); !problem.empty()) {
    errors.add(node.origin, problem);
    return std::nullopt;
  }
  for (const auto& [text, relation] : relations) {
    const std::size_t at = claim.text.find(text);
    if (at == std::string::npos) continue;
    claim.relation = relation;
    const std::string_view left = std::string_view(claim.text).substr(0, at);
    const std::string_view right = std::string_view(claim.text).substr(at + std::string_view(text).size());
    try {
      for (const auto& [side, where] : {std::pair(left, "before"), std::pair(right, "after")})
        if (side.find_first_not_of(' ') == side.npos)
          throw ClaimProblem(std::string("a value is missing ") + where + " \"" + text + '"');
      claim.left = TermParser(left).parse();
      claim.right = TermParser(right).parse();
    } catch (const ClaimProblem& problem) {
      errors.add(node.origin, problem.what());
      return std::nullopt;
    }
    check_names(claim.left, stacks, columns, node, errors);
    check_names(claim.right, stacks, columns, node, errors);
    return claim;
  }
  errors.add(node.origin, "a claim compares with <, <=, >, >= or ==; found \"" + claim.text + "\"" +
                              (claim.text.find('=') != std::string::npos ? "; \"=\" is written \"==\"" : ""));
  return std::nullopt;
}

ClaimResult judge(const Claim& claim, int runs, double share, const ClaimLookup& lookup) {
  ClaimResult result;
  result.text = claim.text;
  result.left = evaluate(claim.left, -1, lookup);
  result.right = evaluate(claim.right, -1, lookup);
  for (int run = 0; run < (claim.about_single_runs() ? runs : 0); ++run) {
    const std::optional<double> left = evaluate(claim.left, run, lookup);
    const std::optional<double> right = evaluate(claim.right, run, lookup);
    ++result.runs;
    if (left && right && compare(*left, claim.relation, *right)) ++result.runs_held;
  }
  // A claim about a value that was not measured does not hold.
  result.medians_hold = result.left && result.right && compare(*result.left, claim.relation, *result.right);
  result.share = share;
  result.holds = result.medians_hold && result.runs_held >= share * result.runs - 1e-9;
  return result;
}

}  // namespace gripline
