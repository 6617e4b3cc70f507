// Editing of the console's input line, and what it completes.
#include <gtest/gtest.h>

#include "sim/ground/console/line_editor.hpp"
#include "sim/ground/console/operator_command.hpp"

namespace ilp::console {
namespace {

constexpr const char *up = "\x1b[A", *down = "\x1b[B";

TEST(LineEditor, ArrowKeysRecallEarlierLinesAndTheOneThatWasBegun) {
  LineEditor editor;
  editor.take("ping\nstrip end\ncap");
  EXPECT_EQ(editor.next_line(), "ping");
  EXPECT_EQ(editor.next_line(), "strip end");
  EXPECT_EQ(editor.next_line(), std::nullopt);
  editor.take(up);
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "strip end");
  editor.take(std::string(up) + up + up);
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "ping") << "there is none before the first";
  editor.take(std::string(down) + down + down);
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "cap");
  editor.take(std::string(up) + "\n");
  EXPECT_EQ(editor.next_line(), "strip end");
}

TEST(LineEditor, ASequenceMayComeInPortionsAndLeavesNothingInTheLine) {
  LineEditor editor;
  editor.take("ping\n\x1b");
  EXPECT_EQ(editor.next_line(), "ping");
  EXPECT_EQ(editor.next_line(), std::nullopt);
  editor.take("[");
  EXPECT_EQ(editor.next_line(), std::nullopt);
  editor.take("A\x1b[3~\x7f");
  EXPECT_EQ(editor.next_line(), std::nullopt);
  EXPECT_EQ(editor.typed(), "pin");
}

TEST(LineEditor, TheTabulatorCompletesCommandsAndParametersAsFarAsTheyAreClear) {
  LineEditor editor(complete_operator_line);
  editor.take("upl\t");
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "uplink ");
  editor.take("\x15set overlap.tar\t");
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "set overlap.target_overlap");
  editor.take("\x15mode \t");
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "mode ");
  EXPECT_EQ(editor.take_choices(), (std::vector<std::string>{"mode regular", "mode forecast", "mode telecommand"}));
  EXPECT_TRUE(editor.take_choices().empty());
  editor.take("\x15xyz\t");
  (void)editor.next_line();
  EXPECT_EQ(editor.typed(), "xyz") << "nothing begins so";
}

}  // namespace
}  // namespace ilp::console
