/// Of C2000Ware's device support: what port/ti_f28004x uses of it.
#ifndef FAKES_TI_DEVICE_H
#define FAKES_TI_DEVICE_H

#define DEVICE_OSCSRC_FREQ 20000000uL
#define DEVICE_LSPCLK_FREQ 25000000uL

void Device_init(void);
void Device_initGPIO(void);

#endif
