#include "tests/faults/memory_parts.hpp"

#include <algorithm>

#include "tests/faults/reveal.hpp"
#include "tests/faults/tiny_flight.hpp"

namespace ilp::faults {

ILP_REVEAL(FlightSoftware, telemetry_writer_);
ILP_REVEAL(FlightSoftware, stages_);
ILP_REVEAL(FlightSoftware, step_memory_);
ILP_REVEAL(FlightSoftware, delivery_queue_);
ILP_REVEAL(Navigator, workspace_);
ILP_REVEAL(FlightSoftware, executive_);

ILP_REVEAL(TelemetryWriter, next_);
ILP_REVEAL(TelemetryWriter, ring_);
ILP_REVEAL(PlaceMemory, workspace_);
ILP_REVEAL(Telecommander, workspace_);
ILP_REVEAL(Acquisition, workspace_);
ILP_REVEAL(OverlapChecker, workspace_);
ILP_REVEAL(TelecommandGuard, workspace_);
ILP_REVEAL(Scrubber, workspace_);
ILP_REVEAL(CameraCalibrator, workspace_);
ILP_REVEAL(StructureAndMotion, workspace_);
ILP_REVEAL(DenseMatcher, workspace_);
ILP_REVEAL(Compressor, workspace_);
ILP_REVEAL(Downlink, workspace_);
ILP_REVEAL(FileDelivery, workspace_);
ILP_REVEAL(TelemetryReporter, workspace_);
ILP_REVEAL(PacketRouter, buffer_);
ILP_REVEAL(PacketRouter, commands_);
ILP_REVEAL(PacketRouter, pdus_);

namespace {

template <typename T>
MemoryRegion region_of(T& object) {
  return {reinterpret_cast<std::byte*>(&object), sizeof(object)};
}

/// `workspaces` lie in `whole`.
void add(std::vector<MemoryPart>& parts, const char* name, MemoryRegion whole, std::vector<MemoryRegion> workspaces) {
  std::sort(workspaces.begin(), workspaces.end(),
            [](const MemoryRegion& a, const MemoryRegion& b) { return a.begin < b.begin; });
  MemoryPart state{std::string(name) + ": state", true, {}};
  std::byte* begin = whole.begin;
  for (const MemoryRegion& region : workspaces) {
    if (region.begin > begin) state.regions.push_back({begin, static_cast<std::size_t>(region.begin - begin)});
    begin = region.begin + region.bytes;
  }
  std::byte* const end = whole.begin + whole.bytes;
  if (end > begin) state.regions.push_back({begin, static_cast<std::size_t>(end - begin)});
  parts.push_back(std::move(state));
  if (!workspaces.empty()) parts.push_back({std::string(name) + ": pixels, workspaces", false, std::move(workspaces)});
}

using Regions = std::vector<MemoryRegion>;

template <typename Owner, typename... Tags>
Regions regions_of(Owner& owner, Tags... members) {
  return {region_of(owner.*revealed(members))...};
}

/// Those members of a component that are workspaces; by default it has none.
template <typename C>
Regions workspaces_of(C& /*component*/) {
  return {};
}
Regions workspaces_of(Telecommander& owner) {
  return regions_of(owner, Telecommander_workspace_{});
}
Regions workspaces_of(Acquisition& owner) {
  return regions_of(owner, Acquisition_workspace_{});
}
Regions workspaces_of(OverlapChecker& owner) {
  return regions_of(owner, OverlapChecker_workspace_{});
}
Regions workspaces_of(Scrubber& owner) {
  return regions_of(owner, Scrubber_workspace_{});
}
Regions workspaces_of(TelecommandGuard& owner) {
  return regions_of(owner, TelecommandGuard_workspace_{});
}
Regions workspaces_of(CameraCalibrator& owner) {
  return regions_of(owner, CameraCalibrator_workspace_{});
}
Regions workspaces_of(StructureAndMotion& owner) {
  return regions_of(owner, StructureAndMotion_workspace_{});
}
Regions workspaces_of(DenseMatcher& owner) {
  return regions_of(owner, DenseMatcher_workspace_{});
}
Regions workspaces_of(Compressor& owner) {
  return regions_of(owner, Compressor_workspace_{});
}
Regions workspaces_of(Downlink& owner) {
  return regions_of(owner, Downlink_workspace_{});
}
Regions workspaces_of(FileDelivery& owner) {
  return regions_of(owner, FileDelivery_workspace_{});
}
Regions workspaces_of(TelemetryReporter& owner) {
  return regions_of(owner, TelemetryReporter_workspace_{});
}
Regions workspaces_of(Navigator& owner) {
  return regions_of(owner, Navigator_workspace_{});
}
Regions workspaces_of(PlaceMemory& owner) {
  return regions_of(owner, PlaceMemory_workspace_{});
}

}  // namespace

std::vector<MemoryPart> memory_parts() {
  const StaticMemory& memory = static_memory();
  FlightSoftware& flight = *memory.software;
  std::vector<MemoryPart> parts;
  add(parts, "mission parameters", region_of(*memory.mission), {});
  Configuration& configuration = flight.configuration();
  add(parts, "nonvolatile memory", region_of(configuration.memory()), {});
  add(parts, "configuration", region_of(configuration), {});
  TelemetryWriter& writer = flight.*revealed(FlightSoftware_telemetry_writer_{});
  add(parts, "telemetry writer", region_of(writer),
      regions_of(writer, TelemetryWriter_next_{}, TelemetryWriter_ring_{}));
  FlightComponents::for_each([&]<typename C>() {
    C& component = (flight.*revealed(FlightSoftware_stages_{})).template get<C>();
    add(parts, stage_of(C::component_id).name, region_of(component), workspaces_of(component));
  });
  parts.push_back({"memory of one step", false, {region_of(flight.*revealed(FlightSoftware_step_memory_{}))}});
  add(parts, "delivery_queue", region_of(flight.*revealed(FlightSoftware_delivery_queue_{})), {});
  add(parts, "executive", region_of(flight.*revealed(FlightSoftware_executive_{})), {});
  PacketRouter& router = flight.router();
  add(parts, "packet router", region_of(router),
      regions_of(router, PacketRouter_buffer_{}, PacketRouter_commands_{}, PacketRouter_pdus_{}));
  add(parts, "store", region_of(*memory.store), {});
  add(parts, "SQLite arena", {memory.sqlite.data(), memory.sqlite.size()}, {});
  return parts;
}

}  // namespace ilp::faults
