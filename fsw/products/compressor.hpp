// Codes only what is newly seen, within the granted bytes: Richness -> Product (paper 4.2; decisions.md, 11).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/products/bit_plan.hpp"
#include "fsw/products/depth_access.hpp"
#include "fsw/products/index_ranks.hpp"
#include "fsw/products/product_metadata.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// A keyframe has two products: its image, with the newly seen part as region of interest, and its inverse depth inside
/// that part. Each is a JP2 file with a metadata box that describes it. The quality of each layer is measured by
/// decoding it. Each step makes one product. The image comes last and completes the keyframe: where the image is on
/// record, so is the depth if there is one. The scheme of an image depends on the rank of its index among those before
/// it; if the checkpoint is older than the products, these keyframes are missing there. If maps cannot be read the
/// image is coded whole. A product whose own input cannot be read is on record as dropped.
class Compressor final : public StageComponent<ComponentId::compressor> {
 public:
  static const CheckpointForm checkpoint;

  struct Workspace {
    FrameImage image;
    MapBuffers maps;
    Jpeg2000Workspace jpeg2000;
    std::array<std::uint8_t, limits::max_product_bytes> file;
  };
  using Scratch = StepScratch<Workspace>;

  Compressor(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory(cursor_, state_).of(*this).at_work(patience_, mean_interval_s_);
  }

 private:
  /// A step makes a product from the records on.
  [[nodiscard]] Workspace& work() const { return scratch_.as<Workspace>(); }

  struct State {
    IndexRanks ranks;  ///< of the keyframes whose image is done
  };

  Status load(std::int64_t keyframe_id, ProductKind kind, Status& damage);
  Status load_depth(std::int64_t keyframe_id, Status& damage);
  Status encode(ProductKind kind, ProductRecord& product);
  Status measure_interval(std::int64_t keyframes, double& interval_s);
  Status write_metadata(const ProductRecord& product);
  Status measure_layers(const Jpeg2000Product& coded, ProductRecord& product);
  Status leave_off_layers(ProductRecord& product);
  Status write(const ProductRecord& product, const Cursor& cursor, const State& after);

  Tables store_;
  const MissionParameters& mission_;
  Scratch scratch_;
  Cursor cursor_;
  State state_;
  Patience patience_;
  ProductSubject subject_;
  double interval_s_ = 0, mean_interval_s_ = 0;
  std::array<std::uint8_t, limits::max_metadata_bytes> metadata_{};
  std::size_t metadata_bytes_ = 0;
  std::array<char, max_sigma_map_bytes> sigma_map_{};
};

}  // namespace ilp
