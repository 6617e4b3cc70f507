// The wide search in the overlap checker: what it changes, and that who does its jobs changes nothing.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "fsw/imaging/overlap_checker.hpp"
#include "tests/support/late_compute.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 96, height = 72;
constexpr double turn_rad = 2.2;

class WideOverlapTest : public test::ComponentTest {
 protected:
  WideOverlapTest() {
    mission.wide_search = true;
    mission.feature_overlap = false;
    write_frame(1, view(0, 0), ns_per_s);
    write_frame(2, view(20, turn_rad), 2 * ns_per_s);
  }
  /// The ground `x` px farther on, turned about the middle of the image.
  static test::Image view(double x, double turn) {
    const double c = std::cos(turn), s = std::sin(turn), mx = 1000 + 0.5 * width + x, my = 2000 + 0.5 * height;
    const Similarity2 ground_from_image{1, turn, mx - 0.5 * (c * width - s * height),
                                        my - 0.5 * (s * width + c * height)};
    return test::render_texture(width, height, ground_from_image, 1, 0, 0, 1);
  }
  /// Runs a new checker; returns the number of steps that waited.
  int choose(Compute* compute, int restart_after = 0) {
    int waited = 0;
    auto checker = std::make_unique<OverlapChecker>(store, mission, test::step_memory<OverlapChecker>(), compute);
    EXPECT_TRUE(restored(checker->restore()));
    for (int i = 0; i < 20'000; ++i) {
      if (i == restart_after) {
        EXPECT_TRUE(restored(checker->restore()));
      }
      const StepResult result = checker->step();
      EXPECT_TRUE(result.status.ok() || result.status.is(StatusCode::overlap_unknown));
      waited += result.then == Then::wait ? 1 : 0;
      if (!result.pending) return waited;
    }
    ADD_FAILURE() << "the search never ends";
    return waited;
  }
  OverlapRecord turned() { return read<OverlapRecord>(2); }

  std::unique_ptr<WideWorkspace> workspace_ = std::make_unique<WideWorkspace>();
  ComputeForms forms_{wide_search_form(*workspace_)};
};

TEST_F(WideOverlapTest, ItRelatesAFrameThatIsTurnedFartherThanTheCoarseSearchReaches) {
  CpuCompute cpu(forms_);
  EXPECT_EQ(choose(&cpu), 0);
  EXPECT_EQ(turned().verdict, OverlapVerdict::ok);
  EXPECT_NEAR(std::remainder(std::fabs(turned().rotation_rad) - turn_rad, 2 * pi), 0, 0.02);
  EXPECT_NEAR(turned().scale, 1, 0.01);
  EXPECT_EQ(read<KeyframeRecord>(2).strip_id, 1);
}

TEST_F(WideOverlapTest, SwitchedOffItRelatesNothing) {
  CpuCompute cpu(forms_);
  mission.wide_search = false;
  choose(&cpu);
  EXPECT_EQ(turned().verdict, OverlapVerdict::overlap_unknown);
}

TEST_F(WideOverlapTest, WithoutAnythingToComputeOnItRelatesNothing) {
  choose(nullptr);
  EXPECT_EQ(turned().verdict, OverlapVerdict::overlap_unknown);
}

/// The same flight once more.
class Again final : public WideOverlapTest {
 public:
  void TestBody() override {}
  using WideOverlapTest::choose;
  using WideOverlapTest::turned;
};

TEST_F(WideOverlapTest, WhoeverDoesTheJobsAndWheneverTheRecordIsTheSame) {
  CpuCompute cpu(forms_);
  choose(&cpu);
  const OverlapRecord at_once = turned();
  ASSERT_EQ(at_once.verdict, OverlapVerdict::ok);
  for (const int restart_after : {0, 40}) {
    const auto again = std::make_unique<Again>();
    test::LateCompute late(forms_, 3);
    EXPECT_GT(again->choose(&late, restart_after), 3);
    const OverlapRecord later = again->turned();
    EXPECT_EQ(later.verdict, at_once.verdict);
    EXPECT_EQ(later.overlap, at_once.overlap);
    EXPECT_EQ(later.rotation_rad, at_once.rotation_rad);
    EXPECT_EQ(later.ncc, at_once.ncc);
  }
}

}  // namespace
}  // namespace ilp
