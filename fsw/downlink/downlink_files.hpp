// Makes and sends the files of Downlink. If a file cannot be made now, Downlink quarantines it.
#pragma once

#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

class DownlinkFiles : public DownlinkPart {
 public:
  using DownlinkPart::DownlinkPart;

  // Each function returns true if it has sent a file.
  Result<bool> send_records(std::int64_t keyframe_id, State& after);
  Result<bool> send_points(std::int64_t id, std::int64_t most, State& after);
  Result<bool> send_layers(const ProductRecord& product, int last_layer, State& after);
  /// Sends the events after `through`, and housekeeping. With `late`, only the events of a lost file that began there.
  Result<bool> send_events(std::int64_t through, bool late, std::int64_t housekeeping_steps, State& after);
  /// A number that changes with the housekeeping.
  [[nodiscard]] std::int64_t housekeeping_fingerprint() const;
  void drop_late(const LateFile& late, State& after);

 private:
  /// Notes whether the store has failed to write, which concerns all files. Returns `answer`.
  Status stored(const Status& answer);
  Status open(const char* name);
  Status close_file(DownlinkRecord sent, State& after);
  Status write_depth(std::int64_t keyframe_id);
  Status write_mask(std::int64_t keyframe_id);
  Status write_link(std::int64_t id);
  Status write_fix(std::int64_t keyframe_id);
  Status write_products_of(std::int64_t keyframe_id, std::int64_t frame_id);
  Status write_frame(std::int64_t id);
  Status write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer, int last_layer);

  OutgoingFile& file_ = workspace_.file;
};

}  // namespace ilp
