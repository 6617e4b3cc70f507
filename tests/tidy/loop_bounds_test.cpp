// A reader of fsw and hal sees in each loop what ends it: it runs over a container, its condition compares what it
// counts or asks a container for its size, or a comment says it (`// bound: ...`).

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Loop {
  std::string kind;       ///< for, while
  std::string head;       ///< what stands in its parentheses
  std::string condition;  ///< empty: none
  std::string body;       ///< of `do` too
  std::string lines;      ///< the line before its head, and the lines of the head
  std::size_t line;
};

/// The index behind the bracket that closes the one before `at`.
std::size_t end_of(const std::string& text, std::size_t at, char open, char close) {
  for (int depth = 1; depth > 0 && at < text.size(); ++at) depth += (text[at] == open) - (text[at] == close);
  return at;
}

/// The index of the bracket that the one at `at` closes.
std::size_t begin_of(const std::string& text, std::size_t at) {
  for (int depth = 1; depth > 0 && at > 0;) {
    --at;
    depth += (text[at] == '}') - (text[at] == '{');
  }
  return at;
}

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    depth += (text[i] == '(' || text[i] == '[') - (text[i] == ')' || text[i] == ']');
    if (depth == 0 && text.compare(i, separator.size(), separator) == 0) {
      parts.emplace_back();
      i += separator.size() - 1;
    } else {
      parts.back() += text[i];
    }
  }
  return parts;
}

std::vector<Loop> loops_in(const std::string& text) {
  static const std::regex word(R"(\b(for|while) \()");
  std::vector<Loop> loops;
  for (std::sregex_iterator it(text.begin(), text.end(), word), none; it != none; ++it) {
    const auto at = static_cast<std::size_t>(it->position());
    const std::size_t begin = at + static_cast<std::size_t>(it->length());
    const std::size_t line = text.rfind('\n', at) + 1;
    if (text.substr(line, at - line).find("//") != std::string::npos) continue;
    const std::size_t end = end_of(text, begin, '(', ')');
    Loop loop{(*it)[1], text.substr(begin, end - 1 - begin), "", "", "", 1};
    loop.line +=
        static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    const std::vector<std::string> parts = split(loop.head, ";");
    if (loop.kind == "for" && parts.size() != 3) continue;  // over a container
    loop.condition = loop.kind == "for" ? parts[1] : loop.head;
    const std::size_t before = line < 2 ? 0 : text.rfind('\n', line - 2) + 1;
    loop.lines = text.substr(before, text.find('\n', end) - before);
    const std::size_t brace = text.find_last_not_of(' ', at - 1), body = text.find_first_not_of(' ', end);
    if (text[brace] == '}' && text.find_first_not_of(' ', line) == brace) {
      loop.body = text.substr(begin_of(text, brace), brace - begin_of(text, brace));
    } else if (text[body] == '{') {
      loop.body = text.substr(body, end_of(text, body + 1, '{', '}') - body);
    } else {
      loop.body = text.substr(end, text.find(';', end) - end);
    }
    loops.push_back(loop);
  }
  return loops;
}

/// What a loop counts up or down, or by which factor.
std::set<std::string> counted_in(const std::string& text) {
  static const std::regex pattern(
      R"((?:\+\+|--)([\w.]*\w)|([\w.]*\w)(?:\+\+|--| (?:[-+*/]|>>|<<)= |\.pop_back\(|\.push_back\())");
  std::set<std::string> names;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), none; it != none; ++it) {
    names.insert((*it)[1].matched ? (*it)[1] : (*it)[2]);
  }
  return names;
}

bool shows_its_bound(const Loop& loop) {
  static const std::regex said("[Bb]ound(ed by|:)"), asks(R"(\.(empty|full)\(\)|< [\w.\->]*\.size\(\))");
  if (loop.condition == "false" || std::regex_search(loop.lines, said)) return true;
  const std::set<std::string> counted = counted_in(loop.head + " " + loop.body);
  for (const std::string& part : split(loop.condition, "&&")) {
    if (part.find("||") != std::string::npos) continue;
    if (std::regex_search(part, asks)) return true;
    for (const std::string& name : counted) {
      const std::string whole =
          "(^|[^\\w.])" + std::regex_replace(name, std::regex("\\."), "\\.") + "(\\.size\\(\\))?(?![\\w(])";
      if (std::regex_search(part, std::regex(whole + ".*(<|>|!=)|(<|>|!=).*" + whole))) return true;
    }
  }
  return false;
}

TEST(Tidy, EveryLoopHasABoundThatAReaderSees) {
  std::size_t seen = 0;
  for (const char* folder : {"fsw", "hal"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ILP_SOURCE_DIR) / folder)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
      std::stringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      for (const Loop& loop : loops_in(text.str())) {
        ++seen;
        EXPECT_TRUE(shows_its_bound(loop)) << entry.path().string() << ":" << loop.line << ": " << loop.kind << " ("
                                           << loop.head << "): say what ends it, // bound: ...";
      }
    }
  }
  EXPECT_GT(seen, 1000U);
}

}  // namespace
