// How long a program takes by the planner of GRBL 1.1.
//
// Links with GRBL's own parser and planner (GPL-3.0, not part of this project) in the place of its stepper driver: a
// block leaves the planner's buffer once the buffer is full, or at the end, and takes the time of the trapezoid between the
// speeds that the planner has given it.
//
// grbl_time FEED_MM_MIN ACCELERATION_MM_S2 JUNCTION_DEVIATION_MM < PROGRAM    prints seconds; exit 1: a block was refused.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "../grbl.h"
#include "avr/io.h"

system_t sys;
volatile io_sim_t io;

static double minutes = 0.0;
static int refused = 0;
// Calls without a character of the program between them, from which on the program waits for the buffer to run empty.
static int idle = 0;
#define WAITS 200

static void take_block(void) {
  plan_block_t *block = plan_get_current_block();
  if (!block) { return; }
  double start = block->entry_speed_sqr, end = plan_get_exec_block_exit_speed_sqr();
  double nominal = plan_compute_profile_nominal_speed(block), a = block->acceleration;
  double top = 0.5 * (start + end) + a * block->millimeters;
  if (top > nominal * nominal) { top = nominal * nominal; }
  double ramps = (2.0 * top - start - end) / (2.0 * a), rest = block->millimeters - ramps;
  minutes += (2.0 * sqrt(top) - sqrt(start) - sqrt(end)) / a + (rest > 0.0 ? rest / sqrt(top) : 0.0);
  plan_discard_current_block();
}

void st_prep_buffer(void) {
  if (plan_check_full_buffer() || ++idle > WAITS) { take_block(); }
  if (!plan_get_current_block()) { system_set_exec_state_flag(EXEC_CYCLE_STOP); }
}
void st_wake_up(void) {}
void st_go_idle(void) {}
void st_reset(void) {}
void st_generate_step_dir_invert_masks(void) {}
void stepper_init(void) {}
void st_update_plan_block_parameters(void) {}
void st_parking_setup_buffer(void) {}
void st_parking_restore_buffer(void) {}
float st_get_realtime_rate(void) { return 0.0f; }

uint8_t serial_read(void) {
  int c = getchar();
  idle = 0;
  if (c == EOF) {
    while (plan_get_current_block()) { take_block(); }
    sys.abort = 1;
    return SERIAL_NO_DATA;
  }
  return (uint8_t)c;
}
void serial_write(uint8_t data) { (void)data; }
uint8_t serial_get_rx_buffer_count(void) { return 0; }
uint8_t serial_get_rx_buffer_available(void) { return 0; }
void report_status_message(uint8_t code) {
  if (code) {
    refused = code;
    sys.abort = 1;
  }
}
void _delay_ms(int i) { (void)i; }
void _delay_us(int i) { (void)i; }

int main(int argc, char **argv) {
  if (argc != 4) { return 2; }
  for (int i = 0; i < N_AXIS; i++) {
    settings.steps_per_mm[i] = 1000.0f;
    settings.max_rate[i] = (float)atof(argv[1]);
    settings.acceleration[i] = (float)(atof(argv[2]) * 3600.0);
  }
  settings.junction_deviation = (float)atof(argv[3]);
  settings.arc_tolerance = 0.001f;
  sys.f_override = sys.r_override = sys.spindle_speed_ovr = 100;
  plan_reset();
  gc_init();
  protocol_main_loop();
  if (refused) {
    fprintf(stderr, "GRBL refuses a block: error %d\n", refused);
    return 1;
  }
  printf("%.6f\n", 60.0 * minutes);
  return 0;
}
