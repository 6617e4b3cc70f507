// Compresses the newly seen part of keyframes within the granted bytes: Richness -> Product (paper 4.2; decisions.md,
// 11).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/products/bit_plan.hpp"
#include "fsw/products/depth_access.hpp"
#include "fsw/products/index_ranks.hpp"
#include "fsw/products/product_coding.hpp"
#include "fsw/products/product_metadata.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"
#include "hal/camera/camera.hpp"
#include "hal/worker/inline_worker.hpp"

namespace ilp {

/// A keyframe has two products: its inverse depth inside the newly seen part, and its image with this part as region of
/// interest. Each is a JP2 file with a metadata box that describes it. The quality of each layer is measured. Two steps
/// load the input of a product and order it from the worker; later steps ask for the result and write it. The image is
/// the last product of a keyframe: when it is on record, so is the depth map if there is one. The scheme of an image
/// depends on the rank of its index among those before it. If the checkpoint is older than the products, the indices of
/// these keyframes are missing in the ranks. If the mask cannot be read the image is coded without a region. A product
/// whose own input cannot be read, or whose job is stuck, is on record as dropped.
class Compressor final : public StageComponent<ComponentId::compressor> {
 public:
  static const CheckpointForm checkpoint;

  /// The input of a product, which a step reads before it orders the product.
  struct Loaded {
    FrameImage image;
    MapBuffers maps;
    std::array<char, max_sigma_map_bytes> sigma_map;
  };
  using Scratch = StepScratch<Loaded>;

  /// If `worker` is null, a job runs in the step that orders it. `worker` must be used by this component only, and must
  /// outlive it, unless it takes no jobs.
  Compressor(Tables store, const MissionParameters& mission, Scratch scratch, Worker* worker = nullptr);

  /// The worker is stuck in a job: only a new process can make products again.
  [[nodiscard]] bool worker_stuck() const { return work_.stuck; }

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

 private:
  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
    Worker* worker;
  };
  struct State {
    IndexRanks ranks;  ///< indices of the keyframes whose image is done
  };
  /// The product that is being made.
  struct Order {
    Cursor after;           ///< the cursor after the product is written
    ProductRecord product;  ///< as ordered
    bool unrated = false;   ///< the richness record is damaged
    bool image = false;
  };
  struct Work {
    Patience patience;
    ProductSubject subject;
    Order order;
    bool loaded = false;                    ///< the input of the order is in the shared memory
    bool handed_over = false;               ///< the worker may be using Workspace::coding
    bool wanted = false;                    ///< the worker's result belongs to the order
    bool stuck = false;                     ///< see worker_stuck()
    std::uint32_t coded_mask_checksum = 0;  ///< checksum_of_mask() of the mask in Workspace::coding; 0: none
    double interval_s = 0, mean_interval_s = 0;
  };
  struct Workspace {
    InlineWorker inline_worker;
    ProductCoding coding{};
  };

  [[nodiscard]] Loaded& loaded() const { return wiring_.scratch.as<Loaded>(); }

  Status load(std::int64_t keyframe_id, ProductKind kind, Status& damage);
  Status load_depth(std::int64_t keyframe_id, ProductKind kind, Status& damage);
  Result<double> measure_interval(std::int64_t keyframes);
  StepResult pick();
  StepResult order_loaded();
  Status order(ProductKind kind);
  Status write_metadata(const ProductRecord& product, ProductBox& box);
  void set_params(const BitPlan& plan);
  bool ask_worker(StepResult& result);
  StepResult finish(const Status& status, ProductRecord product);
  Status write(const ProductRecord& product, const Cursor& cursor, State& after);

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
