// Service 8, function management: the functions of fsw/commanding/functions.inc. Each takes effect by a record that
// another component reads, or by a parameter.
#include "cfg/schedule.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/commanding/function_table.hpp"
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/uplink.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// A request that is not completed within this time has failed.
constexpr TimeNs strip_patience_ns = 600 * ns_per_s;
constexpr TimeNs capture_patience_ns = 60 * ns_per_s;
constexpr TimeNs delete_patience_ns = 600 * ns_per_s;
constexpr TimeNs restart_patience_ns = 10 * ns_per_s;
constexpr std::int64_t longest_pass_s = 1'000'000;
constexpr double farthest_place_m = 1e5;

struct ActiveFunction : ServiceCall {
  ByteReader arguments;
  TimeNs time = 0;
  OpenRequest request = {};  ///< filled by functions that are not completed at once
};

Status command_capture(CommandKind kind, TimeNs at, ActiveFunction& call) {
  call.request.outstanding = 1;
  call.request.deadline_ns = at + ns_from_seconds(call.wiring.mission.capture_timeout_s) + capture_patience_ns;
  CommandRecord command{.kind = kind, .at_ns = at, .request_id = call.request.id};
  command.tag = static_cast<std::int64_t>(call.arguments.number(call.arguments.left()));
  ILP_TRY(write_command(call.wiring, command));
  call.request.subject_id = command.id;
  return {};
}

Status capture(ActiveFunction& call) {
  const TimeNs now = call.now();
  return command_capture(CommandKind::capture_soon, call.change.nominal_ns > now ? call.change.nominal_ns : now, call);
}

Status capture_at(ActiveFunction& call) {
  return command_capture(CommandKind::capture, call.time, call);
}

Status capture_series(ActiveFunction& call) {
  OpenRequest& request = call.request;
  const std::uint32_t interval_ms = call.arguments.u32();
  const std::uint16_t number = call.arguments.u16();
  request.interval_ns = interval_ms * ns_per_ms;
  if (number > 1 && request.interval_ns < ns_from_seconds(call.wiring.mission.capture_min_interval_s)) {
    return out_of_range(Argument::interval, interval_ms / 1000.0);
  }
  if (number == 0) return out_of_range(Argument::repetitions, number);
  if (request.interval_ns > farthest_ns / number) return out_of_range(Argument::interval, interval_ms / 1000.0);
  request.next_ns = call.time;
  request.left = number;
  request.deadline_ns = call.time + (number - 1) * request.interval_ns +
                        ns_from_seconds(call.wiring.mission.capture_timeout_s) + capture_patience_ns;
  return {};
}

Status capture_place(ActiveFunction& call) {
  OpenRequest& request = call.request;
  const MissionParameters& mission = call.wiring.mission;
  CommandRecord command{.kind = CommandKind::capture_place, .request_id = request.id};
  command.longitude_deg = call.arguments.f64();
  command.latitude_deg = call.arguments.f64();
  command.distance_m = call.arguments.f64();
  const std::uint32_t limit_s = call.arguments.u32();
  // What is not a number is in no range.
  if (!(command.longitude_deg >= -360 && command.longitude_deg <= 360)) {
    return out_of_range(Argument::longitude, command.longitude_deg);
  }
  if (!(command.latitude_deg >= -90 && command.latitude_deg <= 90)) {
    return out_of_range(Argument::latitude, command.latitude_deg);
  }
  if (!(command.distance_m > 0 && command.distance_m <= farthest_place_m)) {
    return out_of_range(Argument::place_distance, command.distance_m);
  }
  if (limit_s > farthest_ns / ns_per_s) return out_of_range(Argument::time_limit, limit_s);
  if (!has_places(mission)) return {StatusCode::places_unknown, static_cast<std::int64_t>(mission.body)};
  const TimeNs patience = ns_from_seconds(mission.capture_timeout_s) + capture_patience_ns;
  if (limit_s > 0) command.at_ns = call.now() + limit_s * ns_per_s;
  request.outstanding = 1;
  request.deadline_ns = (limit_s > 0 ? command.at_ns : call.now() + farthest_ns) + patience;
  ILP_TRY(write_command(call.wiring, command));
  request.subject_id = command.id;
  return {};
}

Status capture_mode(ActiveFunction& call) {
  return set_parameter("acquisition", "capture_mode", call.arguments.u8(), call);
}

Status safe_mode(ActiveFunction& call) {
  return set_parameter("flight", "safe_mode", call.arguments.u8(), call);
}

Status command_end_of_strip(ActiveFunction& call) {
  call.request.deadline_ns = call.now() + strip_patience_ns;
  CommandRecord command{.kind = CommandKind::end_strip, .reason = StripEnd::commanded, .request_id = call.request.id};
  ILP_TRY(newest_id<FrameRecord>(call.wiring.store, command.after_frame_id));
  ILP_TRY(write_command(call.wiring, command));
  call.request.subject_id = command.id;
  return {};
}

// They differ in what completes them.
constexpr auto* flush_window = command_end_of_strip;
constexpr auto* begin_strip = command_end_of_strip;
constexpr auto* end_strip = command_end_of_strip;

Status refine_product(ActiveFunction& call) {
  const std::int64_t keyframe_id = number_in_store_epoch<KeyframeRecord>(call.wiring.store, call.arguments.u32());
  ProductRecord product;
  Status found = get(call.wiring.store, product_id(keyframe_id, ProductKind::image), product);
  if (found.is(StatusCode::not_found))
    found = get(call.wiring.store, product_id(keyframe_id, ProductKind::depth), product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, keyframe_id};
  ILP_TRY(found);
  CommandRecord command{
      .kind = CommandKind::refine, .keyframe_id = keyframe_id, .request_id = ++call.change.after.last_request_id};
  return write_command(call.wiring, command);
}

Status delete_product(ActiveFunction& call) {
  OpenRequest& request = call.request;
  const std::int64_t keyframe_id = number_in_store_epoch<KeyframeRecord>(call.wiring.store, call.arguments.u32());
  const std::uint8_t kind = call.arguments.u8();
  if (kind >= static_cast<std::uint8_t>(ProductKind::count)) return out_of_range(Argument::product_kind, kind);
  request.subject_id = product_id(keyframe_id, static_cast<ProductKind>(kind));
  request.deadline_ns = call.now() + delete_patience_ns;
  ProductRecord product;
  const Status found = get(call.wiring.store, request.subject_id, product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, request.subject_id};
  ILP_TRY(found);
  CommandRecord command{
      .kind = CommandKind::delete_product, .subject_id = request.subject_id, .request_id = request.id};
  return write_command(call.wiring, command);
}

Status begin_pass(ActiveFunction& call) {
  const std::uint32_t length_s = call.arguments.u32();
  if (length_s == 0 || length_s > longest_pass_s) return out_of_range(Argument::pass_length, length_s);
  MissionParameters wanted = call.work.wanted;
  open_contact(call.now(), length_s, wanted);
  return set_parameters(wanted, call, Configuration::Way::bounded);
}

Status end_pass(ActiveFunction& call) {
  MissionParameters wanted = call.work.wanted;
  close_contact(call.now(), wanted);
  return set_parameters(wanted, call, Configuration::Way::bounded);
}

Status restart_component(ActiveFunction& call) {
  OpenRequest& request = call.request;
  const std::uint8_t number = call.arguments.u8();
  if (find_stage(number) == nullptr) return out_of_range(Argument::component, number);
  request.subject_id = number;
  request.deadline_ns = call.now() + restart_patience_ns;
  ILP_TRY(newest_id<EventRecord>(call.wiring.store, request.mark_id));
  CommandRecord command{.kind = CommandKind::restart, .subject_id = number, .request_id = request.id};
  return write_command(call.wiring, command);
}

Status suspend_transfer(ActiveFunction& call) {
  return request_transfer(call.wiring.store, call.arguments.u32(), TransferWish::suspend);
}

Status resume_transfer(ActiveFunction& call) {
  return request_transfer(call.wiring.store, call.arguments.u32(), TransferWish::resume);
}

Status cancel_transfer(ActiveFunction& call) {
  return request_transfer(call.wiring.store, call.arguments.u32(), TransferWish::cancel);
}

Status activate_file(ActiveFunction& call) {
  MissionParameters wanted = call.work.wanted;
  const std::int64_t id = number_in_store_epoch<UplinkRecord>(call.wiring.store, call.arguments.u32());
  ILP_TRY(activate_uplink(call.wiring.store, id, call.now(), wanted));
  return set_parameters(wanted, call, Configuration::Way::file);
}

struct Effect {
  Function function;
  Status (*take)(ActiveFunction& call);
  OpenKind completion;
};
constexpr Effect effects[] = {
#define FUNCTION(number, effect, name, arguments, completion, meaning) {Function::effect, effect, OpenKind::completion},
#include "fsw/commanding/functions.inc"
};

}  // namespace

Status serve_functions(ServiceCall& call) {
  if (call.telecommand.subtype != function_management::perform) return call.subtype_unknown();
  FunctionCall request;
  ILP_TRY(decode_function(call.telecommand.data, request));
  call.answer.accept();
  const FunctionInfo* const function = find_function(request.name);
  if (function == nullptr) return StatusCode::function_unknown;
  ActiveFunction active{{call}, ByteReader(request.arguments)};
  const TimeFormat& format = call.tailoring().time;
  const std::size_t least = function->bytes + (function->has_time ? time_bytes(format) : 0);
  const std::size_t most = least + function->optional;
  const auto came = static_cast<std::int64_t>(request.arguments.size());
  if (request.arguments.size() < least || request.arguments.size() > most) {
    return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
  }
  if (function->has_time) {
    UtcNs utc = 0;
    ILP_TRY(decode_time(format, active.arguments, utc));
    active.time = call.wiring.writer.settings().time.mission(utc);
    const std::size_t left = active.arguments.left();
    if (left < function->bytes || left > std::size_t{function->bytes} + function->optional) {
      return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
    }
    const TimeNs now = call.now();
    if (active.time < now) return {StatusCode::release_in_past, (now - active.time) / ns_per_ms};
    if (active.time - now > farthest_ns) return {StatusCode::time_out_of_range, utc / (seconds_per_day * ns_per_s)};
  }
  for (const Effect& effect : effects) {
    if (effect.function != function->function) continue;
    if (effect.completion == OpenKind::noted) return effect.take(active);
    active.request.kind = effect.completion;
    active.request.id = ++call.change.after.last_request_id;
    ILP_TRY(effect.take(active));
    return keep_open(active.request, call);
  }
  return StatusCode::function_unknown;
}

}  // namespace ilp
