#include "tests/faults/memory_parts.hpp"

#include <algorithm>

#include "tests/faults/reveal.hpp"
#include "tests/faults/tiny_flight.hpp"

namespace ilp::faults {

ILP_REVEAL(FlightSoftware, telemetry_writer_);
ILP_REVEAL(FlightSoftware, stages_);
ILP_REVEAL(FlightSoftware, step_memory_);
ILP_REVEAL(FlightSoftware, delivery_queue_);
ILP_REVEAL(PlaceMemory, seen_);
ILP_REVEAL(PlaceMemory, other_seen_);
ILP_REVEAL(PlaceMemory, depths_);
ILP_REVEAL(PlaceMemory, known_);
ILP_REVEAL(PlaceMemory, features_);
ILP_REVEAL(PlaceMemory, older_);
ILP_REVEAL(PlaceMemory, feature_depths_);
ILP_REVEAL(PlaceMemory, older_depths_);
ILP_REVEAL(PlaceMemory, patches_);
ILP_REVEAL(PlaceMemory, older_patches_);
ILP_REVEAL(PlaceMemory, sightings_);
ILP_REVEAL(PlaceMemory, match_);
ILP_REVEAL(PlaceMemory, matches_);
ILP_REVEAL(PlaceMemory, image_);
ILP_REVEAL(PlaceMemory, mask_bytes_);
ILP_REVEAL(PlaceMemory, after_);
ILP_REVEAL(PlaceMemory, table_);
ILP_REVEAL(PlaceMemory, index_);
ILP_REVEAL(Navigator, workspace_);
ILP_REVEAL(FlightSoftware, executive_);

ILP_REVEAL(TelemetryWriter, next_);
ILP_REVEAL(TelemetryWriter, ring_);
ILP_REVEAL(Telecommander, workspace_);
ILP_REVEAL(Acquisition, workspace_);
ILP_REVEAL(OverlapChecker, workspace_);
ILP_REVEAL(TelecommandGuard, workspace_);
ILP_REVEAL(Scrubber, workspace_);
ILP_REVEAL(CameraCalibrator, workspace_);
ILP_REVEAL(CameraCalibrator, images_);
ILP_REVEAL(CameraCalibrator, corners_);
ILP_REVEAL(CameraCalibrator, matches_);
ILP_REVEAL(CameraCalibrator, window_);
ILP_REVEAL(StructureAndMotion, images_);
ILP_REVEAL(StructureAndMotion, corners_);
ILP_REVEAL(StructureAndMotion, matches_);
ILP_REVEAL(StructureAndMotion, depths_);
ILP_REVEAL(DenseMatcher, plan_);
ILP_REVEAL(DenseMatcher, matcher_);
ILP_REVEAL(DenseMatcher, left_);
ILP_REVEAL(DenseMatcher, right_);
ILP_REVEAL(DenseMatcher, rectified_left_);
ILP_REVEAL(DenseMatcher, rectified_right_);
ILP_REVEAL(DenseMatcher, valid_left_);
ILP_REVEAL(DenseMatcher, valid_right_);
ILP_REVEAL(DenseMatcher, disparity_);
ILP_REVEAL(DenseMatcher, disparity_sigma_);
ILP_REVEAL(DenseMatcher, maps_);
ILP_REVEAL(DenseMatcher, now_);
ILP_REVEAL(DenseMatcher, work_);
ILP_REVEAL(DenseMatcher, after_);
ILP_REVEAL(DenseMatcher, before_);
ILP_REVEAL(Compressor, coding_);
ILP_REVEAL(Downlink, file_);
ILP_REVEAL(Downlink, candidates_);
ILP_REVEAL(Downlink, plan_);
ILP_REVEAL(Downlink, workspace_);
ILP_REVEAL(FileDelivery, pdu_);
ILP_REVEAL(FileDelivery, data_);
ILP_REVEAL(TelemetryReporter, workspace_);
ILP_REVEAL(PacketRouter, buffer_);
ILP_REVEAL(PacketRouter, commands_);
ILP_REVEAL(PacketRouter, pdus_);

namespace {

template <typename T>
MemoryPiece piece_of(T& object) {
  return {reinterpret_cast<std::byte*>(&object), sizeof(object)};
}

/// `workspaces` lie in `whole`.
void add(std::vector<MemoryPart>& parts, const char* name, MemoryPiece whole, std::vector<MemoryPiece> workspaces) {
  std::sort(workspaces.begin(), workspaces.end(),
            [](const MemoryPiece& a, const MemoryPiece& b) { return a.begin < b.begin; });
  MemoryPart state{std::string(name) + ": state", true, {}};
  std::byte* begin = whole.begin;
  for (const MemoryPiece& piece : workspaces) {
    if (piece.begin > begin) state.pieces.push_back({begin, static_cast<std::size_t>(piece.begin - begin)});
    begin = piece.begin + piece.bytes;
  }
  std::byte* const end = whole.begin + whole.bytes;
  if (end > begin) state.pieces.push_back({begin, static_cast<std::size_t>(end - begin)});
  parts.push_back(std::move(state));
  if (!workspaces.empty()) parts.push_back({std::string(name) + ": pixels, workspaces", false, std::move(workspaces)});
}

using Pieces = std::vector<MemoryPiece>;

template <typename Owner, typename... Tags>
Pieces pieces_of(Owner& owner, Tags... members) {
  return {piece_of(owner.*revealed(members))...};
}

/// Those members of a component that are workspaces; by default it has none.
template <typename C>
Pieces workspaces_of(C& /*component*/) {
  return {};
}
Pieces workspaces_of(Telecommander& owner) {
  return pieces_of(owner, Telecommander_workspace_{});
}
Pieces workspaces_of(Acquisition& owner) {
  return pieces_of(owner, Acquisition_workspace_{});
}
Pieces workspaces_of(OverlapChecker& owner) {
  return pieces_of(owner, OverlapChecker_workspace_{});
}
Pieces workspaces_of(Scrubber& owner) {
  return pieces_of(owner, Scrubber_workspace_{});
}
Pieces workspaces_of(TelecommandGuard& owner) {
  return pieces_of(owner, TelecommandGuard_workspace_{});
}
Pieces workspaces_of(CameraCalibrator& owner) {
  return pieces_of(owner, CameraCalibrator_workspace_{}, CameraCalibrator_images_{}, CameraCalibrator_corners_{},
                   CameraCalibrator_matches_{}, CameraCalibrator_window_{});
}
Pieces workspaces_of(StructureAndMotion& owner) {
  return pieces_of(owner, StructureAndMotion_images_{}, StructureAndMotion_corners_{}, StructureAndMotion_matches_{},
                   StructureAndMotion_depths_{});
}
Pieces workspaces_of(DenseMatcher& owner) {
  return pieces_of(owner, DenseMatcher_plan_{}, DenseMatcher_matcher_{}, DenseMatcher_left_{}, DenseMatcher_right_{},
                   DenseMatcher_rectified_left_{}, DenseMatcher_rectified_right_{}, DenseMatcher_valid_left_{},
                   DenseMatcher_valid_right_{}, DenseMatcher_disparity_{}, DenseMatcher_disparity_sigma_{},
                   DenseMatcher_maps_{}, DenseMatcher_now_{}, DenseMatcher_work_{}, DenseMatcher_after_{},
                   DenseMatcher_before_{});
}
Pieces workspaces_of(Compressor& owner) {
  return pieces_of(owner, Compressor_coding_{});
}
Pieces workspaces_of(Downlink& owner) {
  return pieces_of(owner, Downlink_file_{}, Downlink_candidates_{}, Downlink_plan_{}, Downlink_workspace_{});
}
Pieces workspaces_of(FileDelivery& owner) {
  return pieces_of(owner, FileDelivery_pdu_{}, FileDelivery_data_{});
}
Pieces workspaces_of(TelemetryReporter& owner) {
  return pieces_of(owner, TelemetryReporter_workspace_{});
}
Pieces workspaces_of(Navigator& owner) {
  return pieces_of(owner, Navigator_workspace_{});
}
Pieces workspaces_of(PlaceMemory& owner) {
  return pieces_of(owner, PlaceMemory_seen_{}, PlaceMemory_other_seen_{}, PlaceMemory_depths_{}, PlaceMemory_known_{},
                   PlaceMemory_features_{}, PlaceMemory_older_{}, PlaceMemory_feature_depths_{},
                   PlaceMemory_older_depths_{}, PlaceMemory_patches_{}, PlaceMemory_older_patches_{},
                   PlaceMemory_sightings_{}, PlaceMemory_match_{}, PlaceMemory_matches_{}, PlaceMemory_image_{},
                   PlaceMemory_mask_bytes_{}, PlaceMemory_after_{}, PlaceMemory_table_{}, PlaceMemory_index_{});
}

}  // namespace

std::vector<MemoryPart> memory_parts() {
  const StaticMemory& memory = static_memory();
  FlightSoftware& flight = *memory.software;
  std::vector<MemoryPart> parts;
  add(parts, "mission parameters", piece_of(*memory.mission), {});
  Configuration& configuration = flight.configuration();
  add(parts, "small memory", piece_of(configuration.memory()), {});
  add(parts, "configuration", piece_of(configuration), {});
  TelemetryWriter& writer = flight.*revealed(FlightSoftware_telemetry_writer_{});
  add(parts, "telemetry writer", piece_of(writer), pieces_of(writer, TelemetryWriter_next_{}, TelemetryWriter_ring_{}));
  FlightComponents::for_each([&]<typename C>() {
    C& component = (flight.*revealed(FlightSoftware_stages_{})).template get<C>();
    add(parts, stage_of(C::component_id).name, piece_of(component), workspaces_of(component));
  });
  parts.push_back({"memory of one step", false, {piece_of(flight.*revealed(FlightSoftware_step_memory_{}))}});
  add(parts, "delivery_queue", piece_of(flight.*revealed(FlightSoftware_delivery_queue_{})), {});
  add(parts, "executive", piece_of(flight.*revealed(FlightSoftware_executive_{})), {});
  PacketRouter& router = flight.router();
  add(parts, "packet router", piece_of(router),
      pieces_of(router, PacketRouter_buffer_{}, PacketRouter_commands_{}, PacketRouter_pdus_{}));
  add(parts, "store", piece_of(*memory.store), {});
  add(parts, "SQLite arena", {memory.sqlite.data(), memory.sqlite.size()}, {});
  return parts;
}

}  // namespace ilp::faults
