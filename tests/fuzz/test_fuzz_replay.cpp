// Every corpus file and seeded mutations of them, through the targets of fuzzing: what a fuzzer would find in its first
// second is found in every build.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t longest = 2048;

std::vector<Bytes> corpus_of(const Target& target) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path("tests/fuzz/corpus") / target.name)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> corpus;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// A few changes of the kinds that fuzzers make.
void mutate(Bytes& bytes, const std::vector<Bytes>& corpus, std::mt19937& random) {
  static constexpr std::uint8_t special[] = {0x00, 0x01, 0x7F, 0x80, 0xFF};
  const auto pick = [&](std::size_t below) { return below == 0 ? 0 : random() % below; };
  for (auto changes = 1 + pick(8); changes > 0; --changes) {
    const std::size_t at = pick(bytes.size());
    switch (pick(6)) {
      case 0:
        if (!bytes.empty()) bytes[at] ^= static_cast<std::uint8_t>(1U << pick(8));
        break;
      case 1:
        if (!bytes.empty()) bytes[at] = special[pick(std::size(special))];
        break;
      case 2:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random()));
        break;
      case 3:
        bytes.resize(bytes.size() - pick(bytes.size() + 1) / 4);
        break;
      case 4:
        for (std::size_t i = at; i < bytes.size() && i < at + 4; ++i) bytes[i] = static_cast<std::uint8_t>(random());
        break;
      default: {
        const Bytes& other = corpus[pick(corpus.size())];
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(pick(other.size())), other.end());
        break;
      }
    }
  }
  if (bytes.size() > longest) bytes.resize(longest);
}

std::string hex(const Bytes& bytes) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += digits[byte >> 4U];
    text += digits[byte & 15U];
  }
  return text;
}

class FuzzReplay : public testing::TestWithParam<Target> {};

TEST_P(FuzzReplay, CorpusAndMutationsAreDealtWith) {
  const Target& target = GetParam();
  const std::vector<Bytes> corpus = corpus_of(target);
  ASSERT_FALSE(corpus.empty());
  for (const Bytes& bytes : corpus) EXPECT_NO_THROW(target.run(bytes)) << hex(bytes);
  std::mt19937 random(1);
  for (int i = 0; i < target.mutations; ++i) {
    Bytes bytes = corpus[random() % corpus.size()];
    mutate(bytes, corpus, random);
    ASSERT_NO_THROW(target.run(bytes)) << hex(bytes);
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay, testing::ValuesIn(targets),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace ilp::fuzz
