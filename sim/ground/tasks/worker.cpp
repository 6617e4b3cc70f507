#include "sim/ground/tasks/worker.hpp"

#include <atomic>
#include <variant>

#include "sim/ground/export/quick_looks.hpp"
#include "sim/ground/tasks/work_package.hpp"
#include "sim/ground/tasks/work_result.hpp"
#include "sim/host/files.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::tasks {
namespace {
namespace fs = std::filesystem;

class Worker {
 public:
  Worker(const fs::path& out, const WorkParams& params)
      : results_(work_folder(out) / "results"), pictures_(out / "keyframes"), params_(params) {
    host::make_output_folder(results_);
    host::make_output_folder(pictures_);
  }

  void operator()(const QuickLookBlock& block) {
    for_each_without_result(
        WorkKind::quick_looks, block.keyframes.size(),
        [&](std::size_t i) { return std::pair(block.keyframes[i].id, quick_look_digest(block, i)); },
        [&](std::size_t i, WorkResult& result) {
          result.summary = map::bytes_of(exports::quick_look_and_export(block.keyframes[i], block.width_px, pictures_));
        });
  }

  void operator()(TileBlock& block) {
    intake::Flight flight;
    for (intake::Keyframe& keyframe : block.keyframes) flight.keyframes.emplace(keyframe.id, std::move(keyframe));
    map::PatchCache patches(flight, params_.chunk_bytes);
    for_each_without_result(
        WorkKind::tiles, block.tiles.size(),
        [&](std::size_t i) { return std::pair(block.strip_id, block.tiles[i].digest); },
        [&](std::size_t i, WorkResult& result) {
          const map::SurfaceTile tile = map::paint(block.tiles[i], block.cell, patches);
          result.place = block.tiles[i].place;
          result.summary = map::bytes_of(tile.summary);
          result.cells = map::bytes_of(tile.cells);
        });
  }

  void operator()(const FinishBlock& block) {
    for_each_without_result(
        WorkKind::finish, block.tiles.size(),
        [&](std::size_t i) { return std::pair(block.strip_id, block.tiles[i].digest); },
        [&](std::size_t i, WorkResult& result) {
          result.place = block.tiles[i].place;
          result.summary = map::finished_summary();
          result.cells = map::finished_cells(block.painted[i], block.tiles[i], block.cell);
        });
  }

  [[nodiscard]] WorkDone done() const { return {patches_, before_}; }

 private:
  [[nodiscard]] static std::uint64_t quick_look_digest(const QuickLookBlock& block, std::size_t i) {
    return exports::quick_look_digest(block.keyframes[i], block.width_px);
  }

  /// `key_of(i)` is the owner and the digest of a result, `fill(i, result)` computes it.
  template <typename KeyOf, typename Fill>
  void for_each_without_result(WorkKind kind, std::size_t count, KeyOf key_of, Fill fill) {
    patches_ += count;
    host::for_each_parallel(
        count,
        [&](std::size_t i) {
          WorkResult result;
          result.kind = kind;
          std::tie(result.owner, result.digest) = key_of(i);
          if (has_result(results_, name_of(kind, result.owner, result.digest))) {
            ++before_;
            return;
          }
          fill(i, result);
          write_result(result, results_);
        },
        params_.threads);
  }

  fs::path results_, pictures_;
  WorkParams params_;
  std::size_t patches_ = 0;
  std::atomic<std::size_t> before_{0};
};

}  // namespace

WorkDone do_work(const fs::path& package, const fs::path& out, const WorkParams& params) {
  Worker worker(out, params);
  PackageReader reader(package);
  while (auto block = reader.next()) std::visit(worker, *block);
  return worker.done();
}

}  // namespace ilp::tasks
