#include "server/api/routes/routes.hpp"

namespace headstock::api {

void add_all_routes(Router& router, Services& services) {
  router.add(system_routes(services, router));
  router.add(session_routes(services));
  router.add(user_routes(services));
  router.add(people_routes(services));
  router.add(audit_routes(services));
  router.add(alarm_rule_routes(services));
  router.add(backup_routes(services));
  router.add(provider_routes(services));
  router.add(machine_routes(services));
  router.add(history_routes(services));
  router.add(accounting_routes(services));
  router.add(value_routes(services));
  router.add(count_routes(services));
  router.add(program_routes(services));
  router.add(revision_routes(services));
  router.add(transfer_routes(services));
  router.add(port_routes(services));
  router.add(port_record_routes(services));
}

}  // namespace headstock::api
