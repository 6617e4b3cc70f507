#include "hal/store/sqlite/sqlite_memory.hpp"

#include <sqlite3.h>

namespace ilp {
namespace {

Arena* sqlite_arena = nullptr;
std::int64_t refused_bytes = 0;

void* granted(void* pointer, int bytes) {
  if (pointer == nullptr) refused_bytes = bytes;
  return pointer;
}
void* take(int bytes) {
  return granted(sqlite_arena->allocate(static_cast<std::size_t>(bytes)), bytes);
}
void give_back(void* pointer) {
  sqlite_arena->release(pointer);
}
void* resize(void* pointer, int bytes) {
  return granted(sqlite_arena->reallocate(pointer, static_cast<std::size_t>(bytes)), bytes);
}
int size_of(void* pointer) {
  return static_cast<int>(sqlite_arena->usable_size(pointer));
}
int round_up(int bytes) {
  constexpr int alignment = static_cast<int>(Arena::alignment);
  return (bytes + alignment - 1) / alignment * alignment;
}
int initialise(void*) {
  return SQLITE_OK;
}
void shut_down(void*) {}

}  // namespace

std::int64_t refused_sqlite_bytes() {
  return refused_bytes;
}

Status configure_sqlite_memory(Arena& arena) {
  sqlite_arena = &arena;
  static const sqlite3_mem_methods methods = {take,     give_back,  resize,    size_of,
                                              round_up, initialise, shut_down, nullptr};
  int code = sqlite3_config(SQLITE_CONFIG_MALLOC, &methods);
  if (code == SQLITE_OK) code = sqlite3_config(SQLITE_CONFIG_SINGLETHREAD);
  // Lookaside would take its slots per connection from the same arena; they gain nothing with statements prepared once.
  if (code == SQLITE_OK) code = sqlite3_config(SQLITE_CONFIG_LOOKASIDE, 0, 0);
  if (code == SQLITE_OK) code = sqlite3_initialize();
  return code == SQLITE_OK ? Status{} : Status{StatusCode::store_error, code};
}

}  // namespace ilp
