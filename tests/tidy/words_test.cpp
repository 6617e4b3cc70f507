// The words of the field instead of words of our own: in identifiers, comments, messages and pages.

#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Word {
  std::string_view word, instead;
};

// As a part of an identifier: `heard` also forbids `heard_ns` and, outside the tests, `HeardPacket`.
const std::map<std::string, std::string_view> instead_of = {
    {"anew", "again"},
    {"desk", "queue"},
    {"doubt", "suspicion"},
    {"doubtful", "suspect"},
    {"hangs", "is attached"},
    {"hanging", "single link, weakly connected"},
    {"hear", "receive"},
    {"heard", "received"},
    {"hears", "receives"},
    {"life", "boot, store epoch"},
    {"lives", "boots, store epochs"},
    {"loose", "weakly connected"},
    {"loosely", "weakly"},
    {"news", "updates"},
    {"piece", "patch, segment, chunk"},
    {"pieces", "patches, segments, chunks"},
    {"room", "capacity, free slots"},
    {"rooms", "folders"},
    {"settles", "converges"},
    {"shelf", "static files"},
    {"sound", "valid"},
    {"surround", "extend"},
    {"tell", "report"},
    {"telling", "reporting"},
    {"tells", "reports"},
    {"told", "reported"},
    {"unsound", "invalid"},
    {"worth", "utility"},
};

// Names that are stored, sent or typed by users, and words that mean what they mean everywhere.
const std::set<std::string> exceptions = {
    "life",
    "life_begun",  // of IdentityRecord, and its event
    "TimeDoubt",
    "time_doubt",         // of FrameRecord
    "worth",              // a value of downlink_order
    "make_room",          // by deleting what is older
    "hanging",            // a gondola below its balloon
    "still_life_params",  // for pictures of things on a table
};

// As they stand in a line of a source or a page, in lower case.
constexpr std::array<Word, 14> phrases = {{
    {"small memory", "nonvolatile memory"},
    {"set aside", "quarantined"},
    {"sets aside", "quarantines"},
    {"was given up", "was abandoned"},
    {"is given up", "is abandoned"},
    {"are given up", "are abandoned"},
    {"known again", "recognised"},
    {"on trial", "tentative"},
    {"anew", "again"},
    {"stated sigma", "estimated sigma"},
    {"stated error", "estimated error"},
    {"life of the flight", "store epoch"},
    {"life of the software", "boot"},
    {"loose chain", "weakly connected strip"},
}};

const fs::path root = ILP_SOURCE_DIR;

std::vector<fs::path> files_of(const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const char* const folder : {"fsw", "hal", "cfg", "bsp", "sim", "tests", "docs"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.is_regular_file() && extensions.count(entry.path().extension().string()) != 0)
        files.push_back(entry.path());
    }
  }
  return files;
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool is_letter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// The identifiers of a line, without its comment and the texts between quotation marks.
std::vector<std::string> identifiers_of(const std::string& line) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line.compare(i, 2, "//") == 0) break;
    if (line[i] == '"') {
      for (++i; i < line.size() && line[i] != '"'; ++i) i += line[i] == '\\' ? 1 : 0;
    } else if (is_letter(line[i])) {
      const std::size_t begin = i;
      while (i < line.size() && is_letter(line[i])) ++i;
      found.push_back(line.substr(begin, i - begin));
      --i;
    }
  }
  return found;
}

/// In lower case, in order: `SoundView` has `sound` and `view`.
std::vector<std::string> parts_of(const std::string& identifier) {
  std::vector<std::string> parts(1);
  for (const char c : identifier) {
    const bool upper = std::isupper(static_cast<unsigned char>(c)) != 0;
    if (c == '_' || (upper && !parts.back().empty())) parts.emplace_back();
    if (c != '_') parts.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return parts;
}

/// Whether the line has the phrase, and not only as a part of longer words.
bool has_phrase(const std::string& line, std::string_view phrase) {
  for (std::size_t at = line.find(phrase); at != std::string::npos; at = line.find(phrase, at + 1)) {
    const std::size_t end = at + phrase.size();
    if ((at == 0 || !is_letter(line[at - 1])) && (end == line.size() || !is_letter(line[end]))) return true;
  }
  return false;
}

TEST(Tidy, IdentifiersAreMadeOfTheWordsOfTheField) {
  std::size_t seen = 0;
  for (const fs::path& file : files_of({".hpp", ".cpp"})) {
    if (file.filename() == "words_test.cpp") continue;
    // Names of tests are sentences.
    const bool sentences = fs::relative(file, root).string().rfind("tests/", 0) == 0;
    const std::vector<std::string> lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (const std::string& identifier : identifiers_of(lines[i])) {
        ++seen;
        if (sentences && std::isupper(static_cast<unsigned char>(identifier[0])) != 0) continue;
        if (exceptions.count(identifier) != 0) continue;
        for (const std::string& part : parts_of(identifier)) {
          const auto found = instead_of.find(part);
          if (found == instead_of.end()) continue;
          ADD_FAILURE() << file.string() << ":" << i + 1 << ": " << identifier << ": the field says " << found->second;
        }
      }
    }
  }
  EXPECT_GT(seen, 100'000U);
}

TEST(Tidy, CommentsMessagesAndPagesUseTheWordsOfTheField) {
  for (const fs::path& file : files_of({".hpp", ".cpp", ".inc", ".md"})) {
    if (file.filename() == "words_test.cpp") continue;
    const std::vector<std::string> lines = lines_of(file);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      std::string line = lines[i];
      for (char& c : line) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      for (const Word& w : phrases) {
        EXPECT_FALSE(has_phrase(line, w.word))
            << file.string() << ":" << i + 1 << ": \"" << w.word << "\": the field says " << w.instead;
      }
    }
  }
}

}  // namespace
