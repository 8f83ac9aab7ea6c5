/* Sizes, for callers that mirror the structs. */
#include "usv_board.h"
#include "usv_rc.h"

const size_t host_sizes[] = {sizeof(usv_drive_config), sizeof(usv_board_config), sizeof(usv_board_in), sizeof(usv_board_out), sizeof(usv_board), sizeof(usv_rc)};
