#include "layers/layers.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

namespace gripline::layers {
namespace {

namespace fs = std::filesystem;

using Graph = std::map<std::string, std::set<std::string>>;  // from what to what it knows

struct Include {
  int line = 0;
  bool quoted = false;
  std::string target;
};

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<Include> includes_of(const fs::path& file) {
  static const std::regex form(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> all;
  int number = 0;
  for (const std::string& line : lines_of(file)) {
    ++number;
    std::smatch match;
    if (std::regex_search(line, match, form)) all.push_back({number, match[1] == "\"", match[2]});
  }
  return all;
}

std::string joined(const std::set<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "nothing" : all;
}

/// Names after "May know:", up to the full stop; none where the README has no such sentence.
std::optional<std::set<std::string>> may_know(const std::vector<std::string>& readme) {
  const std::string mark = "May know:";
  std::string text;
  for (const std::string& line : readme)
    if (!text.empty() || line.starts_with(mark)) text += line + ' ';
  const std::size_t end = text.find('.');
  if (text.empty() || end == std::string::npos) return std::nullopt;
  std::string names = text.substr(mark.size(), end - mark.size());
  std::ranges::replace(names, ',', ' ');
  std::istringstream words(names);
  std::set<std::string> all;
  for (std::string word; words >> word;) all.insert(word);
  if (all.empty()) return std::nullopt;
  all.erase("nothing");
  return all;
}

/// The first circle that a walk along the graph meets, as "a -> b -> a"; empty without one.
class Circle {
 public:
  explicit Circle(const Graph& graph) : graph_(graph) {
    for (const auto& [from, ignored] : graph_)
      if (visit(from)) break;
  }
  const std::string& text() const { return text_; }

 private:
  bool visit(const std::string& at) {
    const auto open = std::ranges::find(path_, at);
    if (open != path_.end()) {
      for (auto step = open; step != path_.end(); ++step) text_ += *step + " -> ";
      text_ += at;
      return true;
    }
    if (!done_.insert(at).second) return false;
    path_.push_back(at);
    const auto next = graph_.find(at);
    if (next != graph_.end())
      for (const std::string& to : next->second)
        if (visit(to)) return true;
    path_.pop_back();
    return false;
  }
  const Graph& graph_;
  std::vector<std::string> path_;
  std::set<std::string> done_;
  std::string text_;
};

class Tree {
 public:
  explicit Tree(const fs::path& root) : root_(root) {
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const std::string name = fs::relative(entry.path(), root).generic_string();
      const bool source = name.ends_with(".cpp") || name.ends_with(".hpp");
      if (source) files_.insert(name);
      if (source || entry.path().filename() == "README.md") allowed_[component_of(name)];
    }
  }

  std::vector<std::string> faults() {
    for (auto& [component, known] : allowed_) read_readme(component, known);
    for (const std::string& file : files_) read_file(file);
    for (const Graph* graph : {&allowed_, &includes_})
      if (const Circle circle(*graph); !circle.text().empty()) faults_.push_back("circle: " + circle.text());
    return std::move(faults_);
  }

 private:
  static std::string component_of(const std::string& file) {
    const std::string folder = fs::path(file).parent_path().generic_string();
    return folder.empty() ? "." : folder;
  }

  void read_readme(const std::string& component, std::set<std::string>& known) {
    constexpr std::size_t most_lines = 15;
    const std::string name = (fs::path(component) / "README.md").lexically_normal().generic_string();
    if (!fs::exists(root_ / name)) return faults_.push_back(name + ": missing; each component says what it may know");
    const std::vector<std::string> readme = lines_of(root_ / name);
    if (readme.size() > most_lines)
      faults_.push_back(name + ": " + std::to_string(readme.size()) + " lines, at most " + std::to_string(most_lines));
    const auto names = may_know(readme);
    if (!names)
      return faults_.push_back(name + ": no sentence of the form 'May know: config, util.' or 'May know: nothing.'");
    for (const std::string& other : *names)
      if (!allowed_.contains(other)) faults_.push_back(name + ": there is no component '" + other + "'");
    known = *names;
  }

  void read_file(const std::string& file) {
    for (const Include& include : includes_of(root_ / file)) {
      const std::string place = file + ":" + std::to_string(include.line) + ": ";
      const bool ours = files_.contains(include.target);
      if (include.quoted && !ours)
        faults_.push_back(place + "\"" + include.target + "\" is not a file from the root of the tree" +
                          beside(file, include.target));
      else if (!include.quoted && ours)
        faults_.push_back(place + "<" + include.target + "> is a file of this tree; write it in quotes");
      if (ours) check_arrow(place, file, include.target);
    }
  }

  /// What was meant by a name that is written from the including file's folder.
  std::string beside(const std::string& file, const std::string& target) const {
    const std::string meant = (fs::path(file).parent_path() / target).lexically_normal().generic_string();
    if (files_.contains(meant)) return "; write \"" + meant + "\"";
    return target.starts_with("gripline/") ? "; write <" + target + ">" : "";
  }

  void check_arrow(const std::string& place, const std::string& from, const std::string& to) {
    includes_[from].insert(to);
    const std::string component = component_of(from), other = component_of(to);
    if (component == other || allowed_.at(component).contains(other)) return;
    faults_.push_back(place + "component " + component + " may not know " + other + " (its README allows " +
                      joined(allowed_.at(component)) + ")");
  }

  const fs::path root_;
  std::set<std::string> files_;  // C++ files, by their path from the root
  Graph allowed_;                // components
  Graph includes_;               // files
  std::vector<std::string> faults_;
};

}  // namespace

std::vector<std::string> faults(const fs::path& root) { return Tree(root).faults(); }

}  // namespace gripline::layers
