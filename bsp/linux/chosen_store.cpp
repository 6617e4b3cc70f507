#include "bsp/linux/chosen_store.hpp"

#include <cstring>

#include "bsp/flight/flight_software.hpp"
#ifdef ILP_POSTGRES
#include "fsw/storage/storage_manager.hpp"
#endif

namespace ilp {

bool names_password(const Options& options) {
#ifdef ILP_POSTGRES
  return options.store != nullptr && is_server(options.store) && holds_password(options.store);
#else
  static_cast<void>(options);
  return false;
#endif
}

const char* store_label(const Options& options) {
  return is_server(options.store) ? "the database server" : options.store;
}

Store& ChosenStore::store() {
#ifdef ILP_POSTGRES
  if (server_) return postgres_;
#endif
  return file_.store();
}

StoreSharing& ChosenStore::sharing() {
#ifdef ILP_POSTGRES
  if (server_) return postgres_;
#endif
  return file_;
}

const char* ChosenStore::message() const {
#ifdef ILP_POSTGRES
  return postgres_.message();
#else
  return "";
#endif
}

Status ChosenStore::connect(const Options& options, bool is_primary, const MissionParameters& mission) {
#ifdef ILP_POSTGRES
  for (const CheckpointForm* const form : checkpoint_forms()) {
    // Without its checkpoints a component would not get on.
    if (form->bytes > max_postgres_blob_bytes) {
      return {StatusCode::capacity_exceeded, form->bytes, max_postgres_blob_bytes};
    }
  }
  // What the others make follows from earlier records, and nobody outside is told of it before flush().
  ILP_TRY(postgres_.open(options.store, ~RecordMask{0}, {.create = is_primary, .synchronous = is_primary}));
  server_ = true;
  postgres_.limit(database_limit_bytes(mission));
  return check_checkpoints(postgres_, checkpoint_forms());
#else
  static_cast<void>(options);
  static_cast<void>(is_primary);
  static_cast<void>(mission);
  return StatusCode::unsupported_format;
#endif
}

Status ChosenStore::open(const Options& options, StageMask stages, MissionParameters& mission, DiskWait& wait) {
  const StoreTrouble trouble = options.fly_on ? StoreTrouble::fly_on : StoreTrouble::refuse;
  if (is_server(options.store)) {
    ILP_TRY(connect(options, true, mission));
  } else if (std::strcmp(options.store, "memory") == 0) {
    return file_.begin_in_memory(mission);
  } else if (stages == all_stages) {
    return file_.open(options.store, trouble, mission, &wait);
  } else {
    const Synchronise when = options.virtual_time ? Synchronise::later : Synchronise::behind_commit;
    ILP_TRY(file_.open_as_primary(options.store, trouble, when, mission));
  }
  return sharing().claim(stages);
}

Status ChosenStore::join(const Options& options, StageMask stages, const MissionParameters& mission) {
  ILP_TRY(is_server(options.store) ? connect(options, false, mission) : file_.join(options.store, mission));
  return sharing().claim(stages);
}

void ChosenStore::close() {
#ifdef ILP_POSTGRES
  if (server_) postgres_.close();
  server_ = false;
#endif
  file_.close();
}

}  // namespace ilp
