// How long work tells how far it has come.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "sim/host/progress.hpp"

namespace ilp::host {
namespace {

TEST(Progress, TheTimeThatIsLeftFollowsFromTheShareThatIsDone) {
  EXPECT_EQ(progress_text("Rendering", 20, 80, 10), "Rendering: 20 of 80, about 30 s left");
  EXPECT_EQ(progress_text("Rendering", 1, 301, 1), "Rendering: 1 of 301, about 5 min left");
  EXPECT_EQ(progress_text("Rendering", 0, 80, 10), "Rendering: 0 of 80") << "nothing is done yet";
  EXPECT_EQ(progress_text("Rendering", 7, 0, 10), "Rendering: 7") << "a source without an end";
}

TEST(Progress, ATerminalHasOneLineThatIsRewrittenAndClearedAtTheEnd) {
  std::ostringstream out;
  Progress progress(out, "Flying", ProgressStyle::rewritten);
  progress.update(1, 10, 1);
  progress.update(2, 10, 1.1);
  progress.update(5, 10, 2);
  progress.update(10, 10, 4);
  EXPECT_EQ(out.str(), "\r\033[KFlying: 1 of 10, about 9 s left\r\033[KFlying: 5 of 10, about 2 s left\r\033[K");
}

TEST(Progress, WorkThatEndsEarlyLeavesNoLineBehind) {
  std::ostringstream out;
  { Progress(out, "Flying", ProgressStyle::rewritten).update(1, 10, 1); }
  EXPECT_TRUE(out.str().ends_with("\r\033[K")) << out.str();
}

TEST(Progress, AFileGetsFewWholeLinesAndShortWorkNone) {
  std::ostringstream out;
  Progress progress(out, "Flying", ProgressStyle::lines);
  for (int second = 1; second < 600; ++second) progress.update(static_cast<std::size_t>(second), 600, second);
  progress.update(600, 600, 600);
  const std::string text = out.str();
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_TRUE(text.starts_with("Flying: 5 of 600, about 10 min left\nFlying: 10 of 600,")) << text;
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GT(lines, 5);
  EXPECT_LT(lines, 40);
  std::ostringstream of_short_work;
  Progress brief(of_short_work, "Flying", ProgressStyle::lines);
  brief.update(1, 2, 2);
  brief.update(2, 2, 4);
  EXPECT_EQ(of_short_work.str(), "");
}

TEST(Progress, AStreamThatIsNoTerminalGetsLines) {
  const std::ostringstream out;
  EXPECT_EQ(progress_style(out), ProgressStyle::lines);
}

}  // namespace
}  // namespace ilp::host
