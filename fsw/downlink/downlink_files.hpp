// The files that Downlink makes. One of a class that cannot be made now is quarantined by Downlink.
#pragma once

#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

class DownlinkFiles : public DownlinkPart {
 public:
  using DownlinkPart::DownlinkPart;

  Result<bool> send_records(std::int64_t keyframe_id, State& after);
  Result<bool> send_points(std::int64_t id, std::int64_t most, State& after);
  Result<bool> send_layers(const ProductRecord& product, int last_layer, State& after);
  /// Sends the events after `through`; with `late`, the events of a file that was lost.
  Result<bool> send_events(std::int64_t through, bool late, std::int64_t housekeeping_steps, State& after);
  [[nodiscard]] std::int64_t housekeeping_fingerprint() const;
  void drop_late(const LateFile& late, State& after);

 private:
  /// A fault of the store concerns all files.
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
