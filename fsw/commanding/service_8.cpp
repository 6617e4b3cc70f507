// Service 8 of the Telecommander: the functions of fsw/commanding/functions.inc. Each takes effect by a record that
// another component reads, or by a parameter.
#include "cfg/schedule.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/commanding/telecommander.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/uplink.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/shared/new_command.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// A request that is not completed within this time has failed.
constexpr TimeNs strip_patience_ns = 600 * ns_per_s;
constexpr TimeNs capture_patience_ns = 60 * ns_per_s;
constexpr TimeNs delete_patience_ns = 600 * ns_per_s;
constexpr TimeNs restart_patience_ns = 10 * ns_per_s;
constexpr TimeNs report_patience_ns = 10 * ns_per_s;
constexpr std::int64_t longest_pass_s = 1'000'000;

}  // namespace

constexpr Telecommander::FunctionRow Telecommander::functions[] = {
#define FUNCTION(number, effect, name, arguments, completion, meaning) \
  {Function::effect, &Telecommander::effect, OpenKind::completion},
#include "fsw/commanding/functions.inc"
};

Status Telecommander::service_8(const Telecommand& telecommand, Answer& answer, Change& change) {
  if (telecommand.subtype != function_management::perform) {
    return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  FunctionCall request;
  ILP_TRY(decode_function(telecommand.data, request));
  answer.accept();
  const FunctionInfo* const function = find_function(request.name);
  if (function == nullptr) return StatusCode::function_unknown;
  Call call{.arguments = ByteReader(request.arguments), .answer = answer, .change = change};
  const TimeFormat& format = wiring_.writer.settings().tailoring.time;
  const std::size_t least = function->bytes + (function->has_time ? time_bytes(format) : 0);
  const std::size_t most = least + function->optional;
  const auto came = static_cast<std::int64_t>(request.arguments.size());
  if (request.arguments.size() < least || request.arguments.size() > most) {
    return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
  }
  if (function->has_time) {
    UtcNs utc = 0;
    ILP_TRY(decode_time(format, call.arguments, utc));
    call.time = wiring_.writer.settings().time.mission(utc);
    const std::size_t left = call.arguments.left();
    if (left < function->bytes || left > std::size_t{function->bytes} + function->optional) {
      return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
    }
    const TimeNs now = wiring_.clock.now();
    if (call.time < now) return {StatusCode::release_in_past, (now - call.time) / ns_per_ms};
    if (call.time - now > farthest_ns) return {StatusCode::time_out_of_range, utc / (seconds_per_day * ns_per_s)};
  }
  for (const FunctionRow& row : functions) {
    if (row.function != function->function) continue;
    if (row.completion == OpenKind::noted) return (this->*row.effect)(call);
    call.request.kind = row.completion;
    call.request.id = ++change.after.last_request_id;
    ILP_TRY((this->*row.effect)(call));
    return open(call.request, answer, change);
  }
  return StatusCode::function_unknown;
}

Status Telecommander::write_command(CommandRecord command, std::int64_t& id) {
  command.time_ns = wiring_.clock.now();
  ILP_TRY(put_new_command(wiring_.store, command));
  id = command.id;
  return {};
}

Status Telecommander::open(OpenRequest request, Answer& answer, Change& change) {
  request.packet = answer.request().packet;
  request.source = answer.request().source;
  request.ack_flags = answer.ack_flags();
  if (answer.postponed()) request.begin_ns = change.nominal_ns;
  if (!change.after.open.push_back(request)) {
    return {StatusCode::requests_full, static_cast<std::int64_t>(change.after.open.size())};
  }
  answer.start();
  answer.keep_open();
  return {};
}

Status Telecommander::command_capture(CommandKind kind, TimeNs at, Call& call) {
  call.request.outstanding = 1;
  call.request.deadline_ns = at + ns_from_seconds(wiring_.mission.capture_timeout_s) + capture_patience_ns;
  CommandRecord command;
  command.kind = kind;
  command.at_ns = at;
  command.request_id = call.request.id;
  command.tag = static_cast<std::int64_t>(call.arguments.number(call.arguments.left()));
  return write_command(command, call.request.subject_id);
}

Status Telecommander::capture(Call& call) {
  const TimeNs now = wiring_.clock.now();
  return command_capture(CommandKind::capture_soon, call.change.nominal_ns > now ? call.change.nominal_ns : now, call);
}

Status Telecommander::capture_at(Call& call) {
  return command_capture(CommandKind::capture, call.time, call);
}

Status Telecommander::capture_series(Call& call) {
  OpenRequest& request = call.request;
  const std::uint32_t interval_ms = call.arguments.u32();
  const std::uint16_t number = call.arguments.u16();
  request.interval_ns = interval_ms * ns_per_ms;
  if (number > 1 && request.interval_ns < ns_from_seconds(wiring_.mission.capture_min_interval_s)) {
    return out_of_range(Argument::interval, interval_ms / 1000.0);
  }
  if (number == 0) return out_of_range(Argument::repetitions, number);
  if (request.interval_ns > farthest_ns / number) return out_of_range(Argument::interval, interval_ms / 1000.0);
  request.next_ns = call.time;
  request.left = number;
  request.deadline_ns = call.time + (number - 1) * request.interval_ns +
                        ns_from_seconds(wiring_.mission.capture_timeout_s) + capture_patience_ns;
  return {};
}

Status Telecommander::capture_mode(Call& call) {
  return set_one("acquisition", "capture_mode", call.arguments.u8(), call.change);
}

Status Telecommander::safe_mode(Call& call) {
  return set_one("flight", "safe_mode", call.arguments.u8(), call.change);
}

Status Telecommander::command_end_of_strip(Call& call) {
  call.request.deadline_ns = wiring_.clock.now() + strip_patience_ns;
  CommandRecord command;
  command.kind = CommandKind::end_strip;
  command.reason = StripEnd::commanded;
  command.request_id = call.request.id;
  ILP_TRY(newest_id<FrameRecord>(wiring_.store, command.after_frame_id));
  return write_command(command, call.request.subject_id);
}

Status Telecommander::flush_window(Call& call) {
  return command_end_of_strip(call);
}

Status Telecommander::begin_strip(Call& call) {
  return command_end_of_strip(call);
}

Status Telecommander::end_strip(Call& call) {
  return command_end_of_strip(call);
}

Status Telecommander::refine_product(Call& call) {
  const std::int64_t keyframe_id = number_of_this_life<KeyframeRecord>(wiring_.store, call.arguments.u32());
  ProductRecord product;
  Status found = get(wiring_.store, product_id(keyframe_id, ProductKind::image), product);
  if (found.is(StatusCode::not_found)) found = get(wiring_.store, product_id(keyframe_id, ProductKind::depth), product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, keyframe_id};
  ILP_TRY(found);
  CommandRecord command;
  command.kind = CommandKind::refine;
  command.keyframe_id = keyframe_id;
  command.request_id = ++call.change.after.last_request_id;
  std::int64_t id = 0;
  return write_command(command, id);
}

Status Telecommander::delete_product(Call& call) {
  OpenRequest& request = call.request;
  const std::int64_t keyframe_id = number_of_this_life<KeyframeRecord>(wiring_.store, call.arguments.u32());
  const std::uint8_t kind = call.arguments.u8();
  if (kind >= static_cast<std::uint8_t>(ProductKind::count)) return out_of_range(Argument::product_kind, kind);
  request.subject_id = product_id(keyframe_id, static_cast<ProductKind>(kind));
  request.deadline_ns = wiring_.clock.now() + delete_patience_ns;
  ProductRecord product;
  const Status found = get(wiring_.store, request.subject_id, product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, request.subject_id};
  ILP_TRY(found);
  CommandRecord command;
  command.kind = CommandKind::delete_product;
  command.subject_id = request.subject_id;
  command.request_id = request.id;
  std::int64_t id = 0;
  return write_command(command, id);
}

Status Telecommander::begin_pass(Call& call) {
  const std::uint32_t length_s = call.arguments.u32();
  if (length_s == 0 || length_s > longest_pass_s) return out_of_range(Argument::pass_length, length_s);
  MissionParameters wanted = work_.wanted;
  open_contact(wiring_.clock.now(), length_s, wanted);
  call.change.way = Configuration::Way::bounded;
  return set_all(wanted, call.change);
}

Status Telecommander::end_pass(Call& call) {
  MissionParameters wanted = work_.wanted;
  close_contact(wiring_.clock.now(), wanted);
  call.change.way = Configuration::Way::bounded;
  return set_all(wanted, call.change);
}

Status Telecommander::restart_component(Call& call) {
  OpenRequest& request = call.request;
  const std::uint8_t number = call.arguments.u8();
  if (find_stage(number) == nullptr) return out_of_range(Argument::component, number);
  request.subject_id = number;
  request.deadline_ns = wiring_.clock.now() + restart_patience_ns;
  ILP_TRY(newest_id<EventRecord>(wiring_.store, request.mark_id));
  CommandRecord command;
  command.kind = CommandKind::restart;
  command.subject_id = number;
  command.request_id = request.id;
  std::int64_t id = 0;
  return write_command(command, id);
}

Status Telecommander::suspend_transfer(Call& call) {
  return request_transfer(wiring_.store, call.arguments.u32(), TransferWish::suspend);
}

Status Telecommander::resume_transfer(Call& call) {
  return request_transfer(wiring_.store, call.arguments.u32(), TransferWish::resume);
}

Status Telecommander::cancel_transfer(Call& call) {
  return request_transfer(wiring_.store, call.arguments.u32(), TransferWish::cancel);
}

Status Telecommander::activate_file(Call& call) {
  MissionParameters wanted = work_.wanted;
  const std::int64_t id = number_of_this_life<UplinkRecord>(wiring_.store, call.arguments.u32());
  ILP_TRY(activate_uplink(wiring_.store, id, wiring_.clock.now(), wanted));
  call.change.way = Configuration::Way::file;
  return set_all(wanted, call.change);
}

Status Telecommander::wait_for_telemetry(std::int64_t command_id, Answer& answer, Change& change) {
  OpenRequest request;
  request.kind = OpenKind::report;
  request.id = change.after.last_request_id;
  request.subject_id = command_id;
  request.deadline_ns = wiring_.clock.now() + report_patience_ns;
  return open(request, answer, change);
}

}  // namespace ilp
