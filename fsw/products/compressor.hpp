// Codes only what is newly seen, within the granted bytes: Richness -> Product (paper 4.2; decisions.md, 11).
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

/// A keyframe has two products: its image, with the newly seen part as region of interest, and its inverse depth inside
/// that part. Each is a JP2 file with a metadata box that describes it. The quality of each layer is measured. Two
/// steps load one product's image and maps and order it from the worker, and later ones ask for it and write it. The
/// image comes last and completes the keyframe: where the image is on record, so is the depth if there is one. The
/// scheme of an image depends on the rank of its index among those before it; if the checkpoint is older than the
/// products, these keyframes are missing there. If the mask cannot be read the image is coded whole. A product whose
/// own input cannot be read is on record as dropped, as is one whose job is stuck.
class Compressor final : public StageComponent<ComponentId::compressor> {
 public:
  static const CheckpointForm checkpoint;

  /// What a step reads to order a product.
  struct Loaded {
    FrameImage image;
    MapBuffers maps;
    std::array<char, max_sigma_map_bytes> sigma_map;
  };
  using Scratch = StepScratch<Loaded>;

  /// Without a worker the jobs are run in the step that orders them. `worker` is for this component alone, and outlives
  /// it or takes no job.
  Compressor(Tables store, const MissionParameters& mission, Scratch scratch, Worker* worker = nullptr);

  /// The worker is stuck in a job: only a new process makes products again.
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
    IndexRanks ranks;  ///< of the keyframes whose image is done
  };
  /// The product that is made.
  struct Order {
    Cursor after;           ///< once it is written
    ProductRecord product;  ///< as ordered
    bool unrated = false;   ///< the richness record is damaged
    bool image = false;
  };
  struct Work {
    Patience patience;
    ProductSubject subject;
    Order order;
    bool loaded = false;       ///< what the order needs is in the step's memory
    bool handed_over = false;  ///< Workspace::coding may be the worker's
    bool wanted = false;       ///< its result is that of the order
    bool stuck = false;
    std::uint32_t coded_mask_checksum = 0;  ///< of the code of the mask in Workspace::coding; 0: it is of no code
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
