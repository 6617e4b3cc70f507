// Derives from a list of component types and the rows of the schedule: the components in their order, the memory that
// they share within a step, the checkpoints that a store must have, and the size of each component.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include "cfg/mission.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/telemetry_writer.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/storage/scrubber.hpp"
#include "fsw/telemetry/telemetry.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"
#include "hal/compute/compute.hpp"
#include "hal/link/link.hpp"
#include "hal/maps/map_source.hpp"
#include "hal/navigation/navigation.hpp"
#include "hal/store/store.hpp"
#include "hal/worker/worker.hpp"

namespace ilp {

/// A static region of the flight's memory and its size.
struct MemoryRegion {
  const char* name;
  std::size_t bytes;
};

/// `Components` has one type for each row of the schedule, in any order.
template <typename... Components>
class ComponentList {
  static constexpr bool has_each_row_once() {
    std::array<int, stage_count> components{};
    (++components[place_of(Components::component_id)], ...);
    for (const int count : components) {
      if (count != 1) return false;
    }
    return true;
  }
  static_assert(has_each_row_once(), "a row of the schedule has no component, or has two");

  template <typename C>
  struct Holder {
    C component;
  };

 public:
  using SharedMemory = StepMemory<Components...>;

  /// Arguments of the components' constructors. `camera`, `link` and `delivery` may be null if no component takes them.
  /// The members after `delivery` are optional.
  struct Parts {
    Store& stored;   ///< the store without a cache
    Store& at_hand;  ///< the same store behind a cache of images
    Clock& clock;
    MissionParameters& mission;
    SharedMemory& step_memory;
    PacketRouter& router;
    TelemetryWriter& writer;
    Camera* camera = nullptr;
    Link* link = nullptr;
    DeliveryFigures* delivery = nullptr;
    const Health* health = nullptr;
    NavigationSource* navigation = nullptr;
    MapFolder* map = nullptr;
    Worker* worker = nullptr;
    Compute* compute = nullptr;
    Configuration* configuration = nullptr;
    FlightMemory* memory = nullptr;
    ImageRegions image = {};  ///< code and constants of the program
  };

  /// Makes a component. Its constructor takes a store and then parts of the types in Parts, in any order. Only the
  /// scrubber gets `stored`, because it must read the stored bytes.
  template <typename C>
  static C made_of(const Parts& parts) {
    Store& store = C::component_id == ComponentId::scrubber ? parts.stored : parts.at_hand;
    const Part part{parts};
    return made_with<C>(store, part, std::make_index_sequence<most_parts>());
  }

  /// Calls `each.operator()<Component>()` for every type.
  template <typename Each>
  static void for_each(Each each) {
    (each.template operator()<Components>(), ...);
  }

  /// The components of one flight.
  class Set : Holder<Components>... {
   public:
    explicit Set(const Parts& parts) : Holder<Components>{made_of<Components>(parts)}... {}

    template <typename C>
    [[nodiscard]] C& get() {
      return static_cast<Holder<C>&>(*this).component;
    }
    template <typename C>
    [[nodiscard]] const C& get() const {
      return static_cast<const Holder<C>&>(*this).component;
    }
    /// The components in the order in which the executive calls them.
    std::array<Component*, stage_count> in_order() {
      std::array<Component*, stage_count> table{};
      ((table[place_of(Components::component_id)] = &get<Components>()), ...);
      return table;
    }
  };

  /// Name and size of each component, in the order of the schedule.
  static constexpr std::array<MemoryRegion, stage_count> memory() {
    std::array<MemoryRegion, stage_count> table{};
    ((table[place_of(Components::component_id)] = {stage_of(Components::component_id).name, sizeof(Components)}), ...);
    return table;
  }

  /// Forms of the checkpoints of all components whose row refuses a state of another build. A store must have these
  /// checkpoints in this form, or not at all.
  static std::span<const CheckpointForm* const> checkpoint_forms() {
    static constexpr auto forms = [] {
      std::array<const CheckpointForm*, 2 * stage_count> table{};
      std::size_t count = 0;
      (add_forms<Components>(table, count), ...);
      return std::pair(table, count);
    }();
    return std::span(forms.first).first(forms.second);
  }

 private:
  /// Converts to the part that has the type of a constructor's argument.
  struct Part {
    const Parts& parts;
    // NOLINTBEGIN(google-explicit-constructor): becoming these is all that it does.
    operator Clock&() const { return parts.clock; }
    operator MissionParameters&() const { return parts.mission; }
    operator PacketRouter&() const { return parts.router; }
    operator TelemetryWriter&() const { return parts.writer; }
    operator DeliveryFigures&() const { return *parts.delivery; }
    operator TelemetrySources() const {
      return {parts.health, parts.delivery != nullptr ? &parts.delivery->counts : nullptr};
    }
    operator Camera&() const { return *parts.camera; }
    operator Link&() const { return *parts.link; }
    operator NavigationSource*() const { return parts.navigation; }
    operator MapSource*() const { return parts.map; }
    operator MapFolder*() const { return parts.map; }
    operator Worker*() const { return parts.worker; }
    operator Compute*() const { return parts.compute; }
    operator Configuration*() const { return parts.configuration; }
    operator FlightMemory*() const { return parts.memory; }
    operator ImageRegions() const { return parts.image; }
    template <typename... Types>
    operator StepScratch<Types...>() const {
      return parts.step_memory;
    }
    // NOLINTEND(google-explicit-constructor)
  };

  static constexpr std::size_t most_parts = 6;
  template <std::size_t>
  using PartAt = Part;
  /// Calls the constructor with the greatest number of parts that it accepts, because its last arguments may have
  /// defaults.
  template <typename C, std::size_t... i>
  static C made_with(Store& store, const Part& part, std::index_sequence<i...>) {
    if constexpr (std::is_constructible_v<C, Store&, PartAt<i>...>) {
      return C(store, (static_cast<void>(i), part)...);
    } else {
      return made_with<C>(store, part, std::make_index_sequence<sizeof...(i) - 1>());
    }
  }

  template <typename C>
  static constexpr void add_forms(std::array<const CheckpointForm*, 2 * stage_count>& table, std::size_t& count) {
    constexpr const StateLayout& state = stage_of(C::component_id).state;
    if constexpr (state.old == OldState::dropped) {
      return;
    } else {
      table[count++] = &C::checkpoint;
      if constexpr (state.second != 0) table[count++] = &C::second_checkpoint;
    }
  }
};

}  // namespace ilp
