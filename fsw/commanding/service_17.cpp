// Service 17, test: tests of the connection.
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/packets/service_functions.hpp"

namespace ilp {

Status serve_tests(ServiceCall& call) {
  const std::uint16_t apid = call.wiring.writer.settings().apid;
  if (call.telecommand.subtype == test_service::are_you_alive) {
    if (!call.telecommand.data.empty()) return {StatusCode::request_malformed, 0};
    call.answer.start();
    return call.answer.report(test_service::service, test_service::alive, {});
  }
  if (call.telecommand.subtype != test_service::connection_test) return call.subtype_unknown();
  std::uint16_t application = 0;
  ILP_TRY(decode_connection(call.telecommand.data, application));
  call.answer.accept();
  if (application != apid) return {StatusCode::packet_apid, application, apid};
  call.answer.start();
  return call.answer.report(test_service::service, test_service::connected, call.telecommand.data);
}

}  // namespace ilp
