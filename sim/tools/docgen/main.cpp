// ilp-docgen DIR: writes the pages of docs/ that follow from tables in the code, and the tables of measured figures.

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "sim/host/files.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/docgen/documents.hpp"
#include "sim/tools/docgen/figures.hpp"

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = ilp::host::read_file(file);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::cout << ilp::host::version_line("ilp-docgen") << "\n";
    return 0;
  }
  const std::string usage =
      "Writes the pages of DIR, such as docs, that follow from tables in the code, and the tables of "
      "DIR/figures/*.json\n"
      "into their pages\nusage: ilp-docgen DIR\n"
      "Example: ilp-docgen docs\nExit status: 0 done, 1 the work could not be done, 2 wrong call\n";
  if (argc == 2 && std::string(argv[1]) == "--help") {
    std::cout << usage;
    return 0;
  }
  if (argc != 2 || argv[1][0] == '-') {
    std::cerr << usage;
    return 2;
  }
  try {
    const fs::path docs = argv[1];
    for (const ilp::docgen::Document& document : ilp::docgen::generated_documents()) {
      const fs::path path = docs / document.file;
      ilp::host::update_file(path, ilp::docgen::placed(document, fs::exists(path) ? text_of(path) : ""));
      std::cout << path.string() << "\n";
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(docs)) {
      if (entry.path().extension() != ".md") continue;
      ilp::host::update_file(entry.path(), ilp::docgen::with_figures(text_of(entry.path()), docs / "figures"));
    }
  } catch (const std::exception& error) {
    std::cerr << "ilp-docgen: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
