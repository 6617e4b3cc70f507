// Files that cannot be written are named, whoever says why.
#include "sim/host/files.hpp"

#include <gtest/gtest.h>

#include <ostream>
#include <stdexcept>
#include <string>

#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

TEST(UpdateFile, NamesTheFileInWhatItsWriterThrowsAndLeavesNothing) {
  const test::ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "map.glb";
  const auto write = [](std::ostream& out) {
    out << "half";
    throw std::runtime_error("a surface without a face");
  };
  EXPECT_EQ(test::error_of([&] { update_file(file, write); }), file.string() + ": a surface without a face");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace ilp::host
