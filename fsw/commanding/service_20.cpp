// Service 20, parameter management: a request sets all of its mission parameters or none.
#include "fsw/commanding/settings.hpp"
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/packets/service_parameters.hpp"

namespace ilp {
namespace {

Status report(ServiceCall& call) {
  ParameterList list;
  ILP_TRY(decode_parameter_list(call.tailoring(), call.telecommand.data, list));
  call.answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (find_parameter(list[i]) == parameter_count()) {
      return {StatusCode::parameter_unknown, list[i], static_cast<std::int64_t>(i)};
    }
  }
  call.answer.start();
  ByteWriter out(call.workspace.report);
  write_count(call.tailoring().parameter_count, list.size(), out);
  for (const std::uint32_t id : list) {
    const std::size_t index = find_parameter(id);
    out.number(id, call.tailoring().parameter_id);
    write_value(parameter_info(index).type, parameter_value(call.work.wanted, index), out);
  }
  ILP_ASSERT(out.ok(), list.size());
  return call.answer.report(parameter_management::service, parameter_management::values, out.written());
}

/// Whether the parameters do not contradict each other, and do not lock the ground out.
Status check_together(const MissionParameters& wanted, const ServiceCall& call) {
  ILP_TRY(validate(wanted));
  Configuration* const configuration = call.wiring.configuration;
  return configuration != nullptr ? configuration->check(wanted, call.now()) : Status{};
}

Status set(ServiceCall& call) {
  ByteReader in(call.telecommand.data);
  const std::uint32_t count = read_count(call.tailoring().parameter_count, in);
  if (!in.ok() || count == 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  if (count > limits::max_list_items) return {StatusCode::capacity_exceeded, count, limits::max_list_items};
  MissionParameters wanted = call.work.wanted;
  Status fault;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto id = static_cast<std::uint32_t>(in.number(call.tailoring().parameter_id));
    const std::size_t index = find_parameter(id);
    const bool known = in.ok() && index < parameter_count();
    if (in.ok() && !known) {
      // The length of an unknown value is not known, so that the rest of the request cannot be read.
      call.answer.accept();
      return {StatusCode::parameter_unknown, id, i};
    }
    const double value = known ? read_value(parameter_info(index).type, in) : 0;
    if (!in.ok()) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
    if (fault.ok() && !set_parameter(wanted, index, value).ok()) fault = {StatusCode::parameter_out_of_range, id, i};
  }
  if (in.left() != 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  call.answer.accept();
  ILP_TRY(fault);
  ILP_TRY(check_together(wanted, call));
  call.answer.start();
  return set_parameters(wanted, call);
}

}  // namespace

Status serve_parameters(ServiceCall& call) {
  if (call.telecommand.subtype == parameter_management::report) return report(call);
  if (call.telecommand.subtype == parameter_management::set) return set(call);
  return call.subtype_unknown();
}

Status set_parameter(const char* section, const char* key, double value, ServiceCall& call) {
  MissionParameters wanted = call.work.wanted;
  const std::size_t index = find_parameter(section, key);
  if (!set_parameter(wanted, index, value).ok()) {
    return {StatusCode::parameter_out_of_range, parameter_info(index).number};
  }
  return set_parameters(wanted, call);
}

Status set_parameters(const MissionParameters& wanted, ServiceCall& call, Configuration::Way way) {
  Configuration* const configuration = call.wiring.configuration;
  MissionParameters checked = wanted;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const double value = parameter_value(wanted, i);
    if (!set_parameter(checked, i, value).ok()) {
      return {StatusCode::parameter_out_of_range, parameter_info(i).number};
    }
    if (configuration != nullptr || value == parameter_value(call.work.wanted, i)) continue;
    ILP_TRY(write_setting(call.wiring.store, i, value, call.now()));
  }
  ILP_TRY(check_together(wanted, call));
  if (configuration != nullptr) ILP_TRY(configuration->write(wanted, call.now()));
  call.change.wanted = wanted;
  call.change.way = way;
  call.change.set = true;
  return {};
}

}  // namespace ilp
