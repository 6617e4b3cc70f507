// The head's part in a flight that several processes share (docs/several-machines.md).
#pragma once

#include "bsp/flight/held_camera.hpp"
#include "bsp/flight/node.hpp"
#include "bsp/flight/shared_flight_store.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

class SharedFlight {
 public:
  SharedFlight(Store& store, StoreSharing& sharing, Camera& camera, Clock& clock, StageMask stages, bool virtual_time)
      : sharing_(sharing),
        clock_(clock),
        virtual_time_(virtual_time),
        camera_(camera),
        store_(store),
        held_camera_(camera, store_),
        node_(store, clock, stages) {}

  /// What the stages of the head use instead of the database and the camera. A camera that takes images in real time is
  /// never held.
  [[nodiscard]] Store& store() { return store_; }
  [[nodiscard]] Camera& camera() { return virtual_time_ ? static_cast<Camera&>(held_camera_) : camera_; }

  /// Admits the other processes. `mission` has the parameters of the mission file alone.
  Status begin(const MissionParameters& mission);
  /// Connects again, if the connection was lost. False: it is not there yet, try again.
  bool connected(Executive& executive);
  /// Call it in every minor frame. Returns an event about another process, or ok.
  Status keep_alive(const Executive& executive);
  /// In virtual time: whether the flight has to wait for others. Then it has waited a little.
  bool waited();
  /// In virtual time, when the head itself has no work: whether all processes are done. Then they are told to end.
  bool done(Executive& executive);

 private:
  StoreSharing& sharing_;
  Clock& clock_;
  bool virtual_time_;
  Camera& camera_;
  SharedFlightStore store_;
  HeldCamera held_camera_;
  Node node_;
  std::uint32_t connections_ = 1;
  RealClock board_clock_;  ///< in virtual time that of the flight may stand still
  TimeNs told_ns_ = 0;
  bool waits_for_end_ = false;
};

}  // namespace ilp
