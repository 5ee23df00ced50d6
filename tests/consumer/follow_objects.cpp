// SPDX-License-Identifier: Apache-2.0
// The README's example: prints what moves, as long as the daemon publishes.
#include <cstdio>
#include <egomod/object_list_t.hpp>
#include <lcm/lcm-cpp.hpp>
#include <string>

struct Printer {
  void on_objects(const lcm::ReceiveBuffer*, const std::string&,
                  const egomod::object_list_t* list) {
    for (const egomod::object_t& object : list->objects) {
      if (object.state != egomod::object_t::STATE_MOVING) continue;
      std::printf("pair %lld: object %lld at %.2f m ahead, %.2f m left, %.2f m/s\n",
                  static_cast<long long>(list->sequence), static_cast<long long>(object.id),
                  object.body_pos[0], object.body_pos[1], object.speed);
    }
  }
};

int main() {
  lcm::LCM bus;
  if (!bus.good()) return 1;
  Printer printer;
  bus.subscribe("EGOMOD_OBJECTS", &Printer::on_objects, &printer);
  while (bus.handle() == 0) std::fflush(stdout);
  return 1;
}
