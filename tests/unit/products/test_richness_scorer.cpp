// What the scorer puts on record: every term, by the mission's weights, and a novelty that a restart does not forget.
#include <array>
#include <memory>
#include <set>

#include "fsw/products/richness_scorer.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/shared/component_fixture.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 160;
constexpr std::int32_t height = 120;

struct Term {
  double RichnessRecord::*value;
  double MissionParameters::*weight;
};
constexpr std::array<Term, 11> terms = {{
    {&RichnessRecord::gradient_fine, &MissionParameters::gradient_fine_weight},
    {&RichnessRecord::gradient_coarse, &MissionParameters::gradient_coarse_weight},
    {&RichnessRecord::entropy, &MissionParameters::entropy_weight},
    {&RichnessRecord::contrast, &MissionParameters::contrast_weight},
    {&RichnessRecord::relief, &MissionParameters::relief_weight},
    {&RichnessRecord::slope_steep, &MissionParameters::slope_steep_weight},
    {&RichnessRecord::slope_excess, &MissionParameters::slope_excess_weight},
    {&RichnessRecord::roughness_fine, &MissionParameters::roughness_fine_weight},
    {&RichnessRecord::roughness_coarse, &MissionParameters::roughness_coarse_weight},
    {&RichnessRecord::curvature, &MissionParameters::curvature_weight},
    {&RichnessRecord::novelty, &MissionParameters::novelty_weight},
}};

class RichnessScorerTest : public test::ComponentTest {
 protected:
  /// Keyframes with exact depth over hills, each a little rougher than the previous one.
  void see(int keyframes) {
    const CameraModel camera = test::distorting_camera(width, height);
    CameraRecord record;
    record.width = width;
    record.height = height;
    record.fx = camera.fx;
    record.fy = camera.fy;
    record.cx = camera.cx;
    record.cy = camera.cy;
    record.k1 = camera.k1;
    record.k2 = camera.k2;
    record.p1 = camera.p1;
    record.p2 = camera.p2;
    record.frozen = 1;
    write(record);
    for (int k = 0; k < keyframes; ++k) {
      const auto hills = [k](double x, double y) { return (1 + 0.5 * k) * std::sin(x / 9) * std::cos(y / (11 + k)); };
      put(k + 1,
          test::render_view(camera, test::looking_down({0, 0, 100}), hills, 2, 1, static_cast<std::uint64_t>(k)));
    }
  }

  /// What was scored from one restart to the next; `steps` 0: all.
  /// Scores this number of images; 0: all.
  void score(int images = 0) {
    const auto scorer = std::make_unique<RichnessScorer>(store, mission, test::step_memory<RichnessScorer>());
    ASSERT_TRUE(scorer->restore().ok());
    if (images == 0) {
      EXPECT_TRUE(run(*scorer).empty());
      return;
    }
    for (int i = 0; i < images; ++i) {
      StepResult result = scorer->step();
      while (result.then == Then::keep) result = scorer->step();
      ASSERT_TRUE(result.status.ok());
    }
  }

  /// As if none had been scored.
  void forget() { test::erase_records<RichnessRecord, CheckpointRecord>(store); }

  std::vector<RichnessRecord> scores() {
    std::vector<RichnessRecord> records;
    for (std::int64_t id = 1; id <= number_of<RichnessRecord>(); ++id) records.push_back(read<RichnessRecord>(id));
    return records;
  }

 private:
  void put(std::int64_t id, const test::View& view) {
    KeyframeRecord keyframe{.id = id, .frame_id = id, .strip_id = 1};
    write(keyframe);
    write_frame(id, view.image);

    const std::size_t pixels = view.depth.size();
    std::vector<float> inverse(pixels);
    for (std::size_t i = 0; i < pixels; ++i) inverse[i] = static_cast<float>(1 / view.depth[i]);
    const std::vector<float> sigma(pixels, 1e-5F);
    const std::vector<std::uint8_t> mask(pixels, 255);
    const ImageView<const float> depth{inverse.data(), width, height};
    const ImageView<const float> errors{sigma.data(), width, height};
    DepthCoding coding;
    ASSERT_TRUE(choose_depth_coding(depth, errors, {mask.data(), width, height}, 150, 20, 64, coding).ok());
    std::vector<std::uint8_t> codes(2 * pixels);
    std::vector<std::uint16_t> words(pixels);
    ASSERT_TRUE(encode_depth(depth, errors, {mask.data(), width, height}, coding, {words.data(), width, height}).ok());
    for (std::size_t i = 0; i < pixels; ++i) {
      codes[2 * i] = static_cast<std::uint8_t>(words[i] & 255U);
      codes[2 * i + 1] = static_cast<std::uint8_t>(words[i] >> 8U);
    }
    std::vector<std::uint8_t> mask_bytes(pixels);
    std::size_t mask_size = 0;
    ASSERT_TRUE(encode_mask({mask.data(), width, height}, mask_bytes.data(), mask_bytes.size(), mask_size).ok());
    mask_bytes.resize(mask_size);

    DepthRecord record;
    record.id = id;
    record.strip_id = 1;
    record.verdict = DepthVerdict::ok;
    record.width = width;
    record.height = height;
    record.offset = coding.offset;
    record.step = coding.step;
    record.disparity_per_inverse_depth_px = 150 * 20;
    record.valid = static_cast<std::uint32_t>(pixels);
    record.values.bytes = static_cast<std::uint32_t>(codes.size());
    record.sigma.bytes = static_cast<std::uint32_t>(pixels);
    MaskRecord new_ground;
    new_ground.id = id;
    new_ground.scope = MaskScope::flight;
    new_ground.width = width;
    new_ground.height = height;
    new_ground.newly_seen = static_cast<std::uint32_t>(pixels);
    new_ground.code.bytes = static_cast<std::uint32_t>(mask_size);
    const std::vector<std::uint8_t> sigma_codes(pixels, 1);
    test::write_records(store, record, new_ground);
    Transaction transaction(store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "values", id, 0, codes).ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "sigma", id, 0, sigma_codes).ok());
    ASSERT_TRUE(write_blob<MaskRecord>(store, "code", id, 0, mask_bytes).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }
};

TEST_F(RichnessScorerTest, AKeyframeIsScoredWhenItsMaskIsFinalAndNoLaterOneBeforeIt) {
  see(3);
  MaskRecord mask = read<MaskRecord>(2);
  mask.scope = MaskScope::strip;
  write(mask);
  score();
  EXPECT_EQ(number_of<RichnessRecord>(), 1);
  mask.scope = MaskScope::flight;
  write(mask);
  score();
  EXPECT_EQ(number_of<RichnessRecord>(), 3);
}

TEST_F(RichnessScorerTest, TheIndexOnRecordIsTheWeightedMeanOfTheTermsOnRecord) {
  see(4);
  score();
  const std::vector<RichnessRecord> records = scores();
  ASSERT_EQ(records.size(), 4U);
  for (const RichnessRecord& record : records) {
    double sum = 0;
    double weights = 0;
    for (const Term& term : terms) {
      EXPECT_GE(record.*term.value, 0);
      EXPECT_LT(record.*term.value, 1);
      sum += record.*term.value * (mission.*term.weight);
      weights += mission.*term.weight;
    }
    EXPECT_NEAR(record.richness, sum / weights, 1e-12);
    EXPECT_GT(record.richness, 0.1);
    EXPECT_EQ(record.has_terrain, 1);
    EXPECT_EQ(record.mask_fraction, 1);
    EXPECT_EQ(record.images_learned, record.id - 1);
  }
  EXPECT_GT(records[3].relief, records[0].relief);
}

TEST_F(RichnessScorerTest, AMissionThatLooksForReliefOnlyRanksByIt) {
  for (const Term& term : terms) mission.*term.weight = 0;
  mission.relief_weight = 2;
  mission.relief_half = 0.05;
  see(2);
  score();
  for (const RichnessRecord& record : scores()) {
    EXPECT_DOUBLE_EQ(record.richness, record.relief);
    // Hills of amplitude a: the range of 95 % of a product of sines, 100 away, against the half.
    EXPECT_NEAR(record.relief, 0.3, 0.15);
  }
  EXPECT_TRUE(validate(mission).ok());
  mission.relief_weight = 0;
  EXPECT_EQ(validate(mission).code, StatusCode::parameters_contradict);
}

TEST_F(RichnessScorerTest, ARestartAfterEveryImageChangesNothing) {
  see(6);
  score();
  const std::vector<RichnessRecord> in_one_go = scores();
  ASSERT_EQ(in_one_go.size(), 6U);

  forget();
  for (int k = 0; k < 6; ++k) score(1);
  const std::vector<RichnessRecord> restarted = scores();
  ASSERT_EQ(restarted.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(restarted[i].richness, in_one_go[i].richness);
    EXPECT_EQ(restarted[i].novelty, in_one_go[i].novelty);
    EXPECT_EQ(restarted[i].images_learned, i);
  }
  // From the fourth image on there is something to compare with: no longer the constant of a flight that begins.
  EXPECT_NE(restarted[4].novelty, restarted[0].novelty);
}

TEST_F(RichnessScorerTest, DefaultsOfTheMissionAreThoseOfTheIndex) {
  const RichnessParams from_mission = richness_params(MissionParameters{});
  const RichnessParams defaults;
  for (const auto& [a, b] : {std::pair{from_mission.gradient_fine, defaults.gradient_fine},
                             {from_mission.gradient_coarse, defaults.gradient_coarse},
                             {from_mission.entropy, defaults.entropy},
                             {from_mission.contrast, defaults.contrast},
                             {from_mission.relief, defaults.relief},
                             {from_mission.slope_steep, defaults.slope_steep},
                             {from_mission.slope_excess, defaults.slope_excess},
                             {from_mission.roughness_fine, defaults.roughness_fine},
                             {from_mission.roughness_coarse, defaults.roughness_coarse},
                             {from_mission.curvature, defaults.curvature},
                             {from_mission.novelty, defaults.novelty}}) {
    EXPECT_EQ(a.half, b.half);
    EXPECT_EQ(a.weight, b.weight);
  }
  EXPECT_EQ(from_mission.novelty_memory, defaults.novelty_memory);
  EXPECT_EQ(from_mission.noise_grey, defaults.noise_grey);
}

TEST_F(RichnessScorerTest, AReadThatFailsOnceCostsNoIndex) {
  see(6);
  score();
  const std::vector<RichnessRecord> wanted = scores();
  forget();
  test::FailingStore failing(store);
  std::set<std::pair<RecordType, std::int64_t>> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool read = call.kind == test::StoreCall::read_blob && call.type != RecordType::checkpoint;
    const bool hit = read && failed.emplace(call.type, call.id).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto scorer = std::make_unique<RichnessScorer>(failing, mission, test::step_memory<RichnessScorer>());
  ASSERT_TRUE(scorer->restore().ok());
  run(*scorer);
  EXPECT_EQ(failed.size(), 3 * wanted.size()) << "image, mask and maps of each";
  const std::vector<RichnessRecord> found = scores();
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_EQ(found[i].richness, wanted[i].richness) << i;
    EXPECT_EQ(found[i].images_learned, wanted[i].images_learned) << i;
  }
}

}  // namespace
}  // namespace ilp
