#include "measured/table/formula.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

#include "config/errors.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using Unary = double (*)(double);
using Binary = double (*)(double, double);

const std::map<std::string_view, Unary>& unary() {
  static const std::map<std::string_view, Unary> all = {
      {"abs", [](double x) { return std::abs(x); }},
      {"sqrt", [](double x) { return std::sqrt(x); }},
      {"sin", [](double x) { return std::sin(x); }},
      {"cos", [](double x) { return std::cos(x); }},
      {"tan", [](double x) { return std::tan(x); }},
      {"atan", [](double x) { return std::atan(x); }},
      {"exp", [](double x) { return std::exp(x); }},
      {"log", [](double x) { return std::log(x); }},
      {"sign", [](double x) { return x > 0.0   ? 1.0
                                     : x < 0.0 ? -1.0
                                               : x; }},
      {"rad", [](double x) { return x * std::numbers::pi / 180.0; }},
      {"deg", [](double x) { return x * 180.0 / std::numbers::pi; }},
  };
  return all;
}

const std::map<std::string_view, Binary>& binary() {
  static const std::map<std::string_view, Binary> all = {
      {"min", [](double a, double b) { return std::isnan(a + b) ? not_a_number : std::min(a, b); }},
      {"max", [](double a, double b) { return std::isnan(a + b) ? not_a_number : std::max(a, b); }},
      {"atan2", [](double a, double b) { return std::atan2(a, b); }},
      {"mod", [](double a, double b) { return a - b * std::floor(a / b); }},
  };
  return all;
}

double truth(bool b) { return b ? 1.0 : 0.0; }

/// A comparison; missing where one side is.
template <class Compare>
Binary compared() {
  return [](double a, double b) { return std::isnan(a) || std::isnan(b) ? not_a_number : truth(Compare()(a, b)); };
}

/// A missing side matters only beside one that does not decide already.
double either_of(double a, double b) {
  if ((!std::isnan(a) && a != 0.0) || (!std::isnan(b) && b != 0.0)) return 1.0;
  return std::isnan(a) || std::isnan(b) ? not_a_number : 0.0;
}
double not_of(double x) { return std::isnan(x) ? x : truth(x == 0.0); }
double both_of(double a, double b) { return not_of(either_of(not_of(a), not_of(b))); }

/// C's power makes 1 of a missing base or exponent now and then.
double power_of(double a, double b) { return std::isnan(a) || std::isnan(b) ? not_a_number : std::pow(a, b); }

}  // namespace

/// Recursive descent: or, and, comparison, sum, product, sign, power, atom.
class FormulaParser {
 public:
  using Step = Formula::Step;
  using Values = Formula::Values;
  using Context = Formula::Context;

  FormulaParser(std::string_view text, const DelimitedTable& table, const std::string& what)
      : text_(text), table_(table), what_(what) {}

  Step parse() {
    Step all = any_of();
    skip();
    if (at_ < text_.size()) refuse("unexpected \"" + std::string(text_.substr(at_)) + "\"");
    return all;
  }
  std::vector<std::size_t> columns;

 private:
  [[noreturn]] void refuse(const std::string& problem) const {
    throw InputError(what_ + " \"" + std::string(text_) + "\", character " + std::to_string(at_ + 1) + ": " + problem);
  }
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(std::string_view sign) {
    skip();
    if (!text_.substr(at_).starts_with(sign)) return false;
    at_ += sign.size();
    return true;
  }
  void expect(std::string_view sign) {
    if (!take(sign)) refuse("expected \"" + std::string(sign) + "\"");
  }

  static Step join(Step a, Step b, Binary f) {
    return [a = std::move(a), b = std::move(b), f](const Context& c) {
      Values left = a(c);
      const Values right = b(c);
      for (std::size_t i = 0; i < left.size(); ++i) left[i] = f(left[i], right[i]);
      return left;
    };
  }
  static Step change(Step a, Unary f) {
    return [a = std::move(a), f](const Context& c) {
      Values values = a(c);
      for (double& v : values) v = f(v);
      return values;
    };
  }

  Step any_of() {
    Step left = all_of();
    while (take("||")) left = join(left, all_of(), either_of);
    return left;
  }
  Step all_of() {
    Step left = comparison();
    while (take("&&")) left = join(left, comparison(), both_of);
    return left;
  }
  Step comparison() {
    Step left = sum();
    if (take("<=")) return join(left, sum(), compared<std::less_equal<>>());
    if (take(">=")) return join(left, sum(), compared<std::greater_equal<>>());
    if (take("==")) return join(left, sum(), compared<std::equal_to<>>());
    if (take("!=")) return join(left, sum(), compared<std::not_equal_to<>>());
    if (take("<")) return join(left, sum(), compared<std::less<>>());
    if (take(">")) return join(left, sum(), compared<std::greater<>>());
    return left;
  }
  Step sum() {
    Step left = product();
    while (true) {
      if (take("+"))
        left = join(left, product(), [](double a, double b) { return a + b; });
      else if (take("-"))
        left = join(left, product(), [](double a, double b) { return a - b; });
      else
        return left;
    }
  }
  Step product() {
    Step left = signed_one();
    while (true) {
      if (take("*"))
        left = join(left, signed_one(), [](double a, double b) { return a * b; });
      else if (take("/"))
        left = join(left, signed_one(), [](double a, double b) { return a / b; });
      else
        return left;
    }
  }
  Step signed_one() {
    if (++depth_ > 100) refuse("nested too deeply");
    Step one;
    if (take("-"))
      one = change(signed_one(), [](double x) { return -x; });
    else if (take("+"))
      one = signed_one();
    else if (text_.substr(at_).starts_with("!") && take("!"))
      one = change(signed_one(), not_of);
    else
      one = power();
    --depth_;
    return one;
  }
  Step power() {
    Step base = atom();
    if (take("^")) return join(base, signed_one(), power_of);
    return base;
  }

  Step atom() {
    skip();
    if (at_ >= text_.size()) refuse("the formula ends where a value was expected");
    if (take("(")) {
      Step inside = any_of();
      expect(")");
      return inside;
    }
    const char c = text_[at_];
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') return number();
    if (c == '`') {
      const std::size_t end = text_.find('`', at_ + 1);
      if (end == std::string_view::npos) refuse("the backquote is not closed");
      const std::string_view name = text_.substr(at_ + 1, end - at_ - 1);
      Step step = column(name);
      at_ = end + 1;
      return step;
    }
    return word();
  }

  Step number() {
    double value = 0.0;
    const auto [stop, code] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (code != std::errc()) refuse("expected a number");
    at_ = static_cast<std::size_t>(stop - text_.data());
    return constant(value);
  }
  static Step constant(double value) {
    return [value](const Context& c) { return Values(c.table.rows(), value); };
  }

  Step column(std::string_view name) {
    const int index = table_.find(name);
    if (index < 0) refuse("no column \"" + std::string(name) + "\"" + did_you_mean(name, table_.name));
    const auto i = static_cast<std::size_t>(index);
    columns.push_back(i);
    return [i](const Context& c) { return c.table.column[i]; };
  }

  Step word() {
    std::size_t end = at_;
    const auto part = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c >= 0x80; };
    while (end < text_.size() && part(static_cast<unsigned char>(text_[end]))) ++end;
    const std::string_view name = text_.substr(at_, end - at_);
    if (name.empty()) refuse("expected a value, found \"" + std::string(text_.substr(at_, 1)) + "\"");
    std::size_t behind = end;
    while (behind < text_.size() && text_[behind] == ' ') ++behind;
    if (behind < text_.size() && text_[behind] == '(') {
      Step step = call(name, behind + 1);
      return step;
    }
    Step step = table_.find(name) < 0 && name == "pi" ? constant(std::numbers::pi) : column(name);
    at_ = end;
    return step;
  }

  Step call(std::string_view name, std::size_t inside) {
    const std::size_t begin = at_;
    at_ = inside;
    std::vector<Step> given{any_of()};
    while (take(",")) given.push_back(any_of());
    expect(")");
    const std::size_t end = at_;
    at_ = begin;
    const auto takes = [&](std::size_t count) {
      if (given.size() != count)
        refuse(std::string(name) + "() takes " + std::to_string(count) + " values, found " +
               std::to_string(given.size()));
    };
    Step step;
    if (const auto one = unary().find(name); one != unary().end()) {
      takes(1);
      step = change(given[0], one->second);
    } else if (const auto two = binary().find(name); two != binary().end()) {
      takes(2);
      step = join(given[0], given[1], two->second);
    } else if (name == "clamp") {
      takes(3);
      step = join(join(given[0], given[1], binary().at("max")), given[2], binary().at("min"));
    } else if (name == "if") {
      takes(3);
      step = choose(given[0], given[1], given[2]);
    } else if (name == "rate") {
      takes(1);
      step = rate(given[0]);
    } else if (name == "hold") {
      takes(1);
      step = hold(given[0]);
    } else {
      std::vector<std::string> known = {"clamp", "if", "rate", "hold"};
      for (const auto& [id, f] : unary()) known.emplace_back(id);
      for (const auto& [id, f] : binary()) known.emplace_back(id);
      refuse("no function \"" + std::string(name) + "\"" + did_you_mean(name, known));
    }
    at_ = end;
    return step;
  }

  static Step choose(Step condition, Step yes, Step no) {
    return [condition = std::move(condition), yes = std::move(yes), no = std::move(no)](const Context& c) {
      const Values which = condition(c), other = no(c);
      Values values = yes(c);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = std::isnan(which[i]) ? not_a_number : which[i] != 0.0 ? values[i] : other[i];
      return values;
    };
  }
  static Step rate(Step of) {
    return [of = std::move(of)](const Context& c) {
      const Values values = of(c);
      Values rates(values.size(), not_a_number);
      std::size_t last = values.size();
      for (std::size_t i = 0; i < values.size() && i < c.time.size(); ++i) {
        if (std::isnan(values[i])) continue;
        if (last < i && c.time[i] > c.time[last]) rates[i] = (values[i] - values[last]) / (c.time[i] - c.time[last]);
        last = i;
      }
      return rates;
    };
  }
  static Step hold(Step of) {
    return [of = std::move(of)](const Context& c) {
      Values values = of(c);
      for (std::size_t i = 1; i < values.size(); ++i)
        if (std::isnan(values[i])) values[i] = values[i - 1];
      return values;
    };
  }

  std::string_view text_;
  const DelimitedTable& table_;
  const std::string& what_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Formula::Formula(std::string_view text, const DelimitedTable& table, const std::string& what) {
  FormulaParser parser(text, table, what);
  root_ = parser.parse();
  columns_ = std::move(parser.columns);
}

std::vector<double> Formula::evaluate(const DelimitedTable& table, const std::vector<double>& time) const {
  return root_({table, time});
}

std::vector<std::string> quoted_names(std::string_view formula) {
  std::vector<std::string> names;
  for (std::size_t at = 0; (at = formula.find('`', at)) != std::string_view::npos;) {
    const std::size_t end = formula.find('`', at + 1);
    if (end == std::string_view::npos) break;
    names.emplace_back(formula.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return names;
}

}  // namespace gripline::measured
