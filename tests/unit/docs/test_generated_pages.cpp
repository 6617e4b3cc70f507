// The pages that follow from tables in the code say what the tables say.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "sim/tools/docgen/documents.hpp"

namespace {

TEST(GeneratedPages, CommittedPagesAreThoseTheTablesMake) {
  const std::vector<ilp::docgen::Document> documents = ilp::docgen::generated_documents();
  ASSERT_EQ(documents.size(), 5U + 1U + 11U);
  for (const ilp::docgen::Document& document : documents) {
    std::ifstream in("docs/" + document.file, std::ios::binary);
    ASSERT_TRUE(in) << "docs/" << document.file << " is missing: run build/host/bin/ilp-docgen docs";
    const std::string committed((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    EXPECT_TRUE(!document.part || committed.find(document.text) != std::string::npos)
        << "docs/" << document.file << " has no lines that show where to place what is made";
    EXPECT_TRUE(committed == ilp::docgen::placed(document, committed))
        << "docs/" << document.file << " is out of date: run build/host/bin/ilp-docgen docs";
  }
}

}  // namespace
