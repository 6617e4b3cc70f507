// ilp-docgen DIR: writes the pages of docs/ that follow from tables in the code.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "sim/host/version_line.hpp"
#include "sim/tools/docgen/documents.hpp"

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::cout << ilp::host::version_line("ilp-docgen") << "\n";
    return 0;
  }
  const std::string usage =
      "Writes the pages of DIR, such as docs, that follow from tables in the code\nusage: ilp-docgen DIR\n"
      "Example: ilp-docgen docs\nExit status: 0 done, 1 the work could not be done, 2 wrong call\n";
  if (argc == 2 && std::string(argv[1]) == "--help") {
    std::cout << usage;
    return 0;
  }
  if (argc != 2 || argv[1][0] == '-') {
    std::cerr << usage;
    return 2;
  }
  for (const ilp::docgen::Document& document : ilp::docgen::generated_documents()) {
    const std::filesystem::path path = std::filesystem::path(argv[1]) / document.file;
    std::ifstream in(path, std::ios::binary);
    const std::string page((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!(std::ofstream(path, std::ios::binary) << ilp::docgen::placed(document, page)).flush()) {
      std::cerr << "ilp-docgen: cannot write " << path.string() << "\n";
      return 1;
    }
    std::cout << path.string() << "\n";
  }
  return 0;
}
