#include "bsp/flight/stage_set.hpp"

#include <gtest/gtest.h>

#include <string>

namespace ilp {
namespace {

TEST(StageSet, NamesAndSetsBelongToEachOther) {
  StageMask stages = 0;
  StageNames culprit;
  ASSERT_TRUE(parse_stages("head,dense_matcher,compressor", stages, culprit));
  EXPECT_EQ(stages, primary_stages | stage_bit(ComponentId::dense_matcher) | stage_bit(ComponentId::compressor));
  EXPECT_STREQ(stage_names(stages).c_str(), "head,dense_matcher,compressor");
  EXPECT_EQ(node_number(stages), 1);
  ASSERT_TRUE(parse_stages("compressor", stages, culprit));
  EXPECT_FALSE(is_primary(stages));
  EXPECT_EQ(node_number(stages), static_cast<std::int64_t>(ComponentId::compressor));
}

TEST(StageSet, EveryStageBelongsToThePrimaryOrHasAName) {
  StageMask all = 0;
  StageNames culprit;
  ASSERT_TRUE(parse_stages(stage_names(all_stages).c_str(), all, culprit)) << culprit.c_str();
  EXPECT_EQ(all, all_stages);
}

TEST(StageSet, WhatCannotRunByItselfIsNamed) {
  for (const std::string wrong : {"dense", "acquisition", "", "dense_matcher,", "dense_matcher compressor"}) {
    StageMask stages = 0;
    StageNames culprit;
    EXPECT_FALSE(parse_stages(wrong.c_str(), stages, culprit)) << wrong;
  }
  StageMask stages = 0;
  StageNames culprit;
  ASSERT_FALSE(parse_stages("compressor,telemetry,overlap_checker", stages, culprit));
  EXPECT_STREQ(culprit.c_str(), "telemetry");
}

}  // namespace
}  // namespace ilp
